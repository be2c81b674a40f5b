"""Those of the forty mistakes that no single call is, see `test_mistakes`.

Ctrl-C (5), labels and arrays (27 to 29), two calls at once (32), a full disk (33), settings
(35), the report (38), the README (39), knocks without a time (40).
"""

import dataclasses
import errno
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import jax.numpy as jnp
import numpy as np
import pytest
import report_samples
from mistakes import spoil, told
from tunings import plain

import scdpr_jax
from experiments.cli import main
from experiments.page.number_text import plain as plain_number
from experiments.reports.calibration.heat_tables import misfit_heat
from experiments.runtime.store.lock import locked
from experiments.studies.findings.residuals import excess_sentence, excesses
from experiments.verbs.study import sweep
from scdpr_jax.numerics import files
from tuning.result.document import read_tuning, write_tuning

ROOT = pathlib.Path(__file__).parents[3]
RIG = ROOT.parent / "shared" / "data" / "campaigns" / "rig-a"
needs_rig = pytest.mark.skipif(not RIG.is_dir(), reason="the reference campaign is absent")
ROBOT = scdpr_jax.consistent()

IMPORTS = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)

class Slow:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name == "identification.campaign":
            print("imports", flush=True)
            time.sleep(60)

sys.meta_path.insert(0, Slow)
from experiments.cli import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
@pytest.mark.parametrize("verb", ["identify", "check", "calibrate"])
def test_05_ctrl_c_in_the_middle_of_an_import_is_one_line(verb, tmp_path):
    call = [sys.executable, "-c", IMPORTS, verb, "rig"]
    call += [] if verb == "check" else ["--out", str(tmp_path / "out")]
    pipe = subprocess.PIPE
    child = subprocess.Popen(call, stdout=pipe, stderr=pipe, text=True)
    assert child.stdout.readline() == "imports\n"
    child.send_signal(signal.SIGINT)
    _, told = child.communicate(timeout=60)
    assert child.returncode == 130
    (line,) = told.splitlines()
    assert line.startswith(f"scdpr {verb}: stopped.")
    assert not (tmp_path / "out").exists()


@needs_rig
@pytest.mark.slow
def test_27_a_label_that_no_other_run_bears_out_is_told(tmp_path, capsys):
    shutil.copytree(RIG, tmp_path / "rig")
    for run in ("0003-torque-step", "0004-torque-step"):
        path = tmp_path / "rig" / run / "run.toml"
        path.chmod(0o644)
        spoil(path, '"350 N"', '"200 N"')
    main(["identify", str(tmp_path / "rig"), "--out", str(tmp_path / "out")])
    out = " ".join(capsys.readouterr().out.split())
    assert "The logs can't tell effective pretension at 200 N by itself." in out


def start(x=0.3):
    return scdpr_jax.rest(ROBOT, jnp.array(x), jnp.array(x), jnp.array(0.55))


def inputs(voltage, duration=None):
    steps = np.full(4, 5e-3) if duration is None else duration
    return scdpr_jax.Inputs(duration=steps, voltage=voltage, knock=np.zeros(4))


@pytest.mark.parametrize(
    ("voltage", "message"),
    [
        (np.ones((4, 3)), r"`voltage` \[V\] must have the shape \(4, 2\), got \(4, 3\)"),
        (np.ones((4, 1)), r"must have the shape \(4, 2\), got \(4, 1\)"),
        (np.ones((3, 2)), r"must have the shape \(3,\), got \(4,\)"),
    ],
)
def test_28_voltages_of_another_shape_are_refused(voltage, message):
    with pytest.raises(ValueError, match=message):
        scdpr_jax.simulate(ROBOT, start(), inputs(voltage))


def test_29_what_no_rig_has_is_refused():
    with pytest.raises(ValueError, match=r"`lower` must be in the frame \[m\], got 300 m"):
        start(300.0)
    with pytest.raises(ValueError, match="`duration` must not be negative"):
        inputs(np.ones((4, 2)), -np.ones(4))
    with pytest.raises(ValueError, match="got 100 V, expected at most its `voltage_limit`"):
        scdpr_jax.simulate(ROBOT, start(), inputs(100 * np.ones((4, 2))))
    slippery = scdpr_jax.replace(ROBOT, {"friction_coefficient": -0.1})
    with pytest.raises(ValueError, match=r"friction.coefficient` must not be negative"):
        scdpr_jax.simulate(slippery, start(), inputs(np.ones((4, 2))))


@pytest.mark.parametrize(
    ("call", "kept"),
    [
        (("sweep", "frequency", "--over", "y=0.2..0.9:5 m", "--out"), ".o.nc.unfinished"),
        (("identify", "{rigs}", "--cores", "1", "--out"), "o.nc/.campaigns.unfinished"),
    ],
    ids=["sweep", "batch"],
)
def test_32_two_calls_on_one_output_are_told(call, kept, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sweep, "set_up", lambda **options: None)
    for name in ("a", "b"):
        (tmp_path / "rigs" / name).mkdir(parents=True)
        (tmp_path / "rigs" / name / "campaign.toml").write_text("format = 1")
    words = [word.format(rigs=tmp_path / "rigs") for word in call]
    with locked(tmp_path / kept):
        message = told(capsys, *words, tmp_path / "o.nc")
    assert "`--out`: another process is at it, got a lock on" in message
    assert str(tmp_path / kept) in message
    assert "expected none. Wait for that one, or name another file." in message


def test_33_a_full_disk_is_told_with_the_file(tmp_path, monkeypatch):
    def full(*text, **options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(pathlib.Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left") as caught:
        files.write_whole(tmp_path / "parameters.json", "{}")
    assert caught.value.filename == str(tmp_path / "parameters.json")
    assert not list(tmp_path.iterdir())


def test_35_a_reading_of_a_setting_is_that_setting(tmp_path):
    write_tuning(tmp_path / "tuning.json", plain())
    tuning = read_tuning(tmp_path / "tuning.json")
    region = dataclasses.replace(tuning.shapers[0].region, pretension=(350.0, 350.0))
    own = dataclasses.replace(tuning.shapers[0], region=region)
    tuning = dataclasses.replace(tuning, shapers=(own,))
    x, y, setting = sum(region.x) / 2, sum(region.y) / 2, 350.0
    for reading in (setting - 1e-4, setting + 1e-4, 0.995 * setting):
        assert tuning.shaper_at(x, y, reading) is tuning.shaper_at(x, y, setting)
        assert tuning.robot_at(reading) is tuning.robot_at(setting)
    with pytest.raises(ValueError, match="no shaper"):
        tuning.shaper_at(x, y, 0.9 * setting)


def test_38_text_and_table_have_one_measure_of_misfit():
    estimate = report_samples.estimate(off=5e-3)
    worst = excesses(estimate)[0]
    times = plain_number(math.sqrt(worst.channel.chi_square))
    assert f"({times} times the noise)" in excess_sentence(estimate, excesses(estimate))
    heat = misfit_heat(estimate.comparisons)
    (row,) = (row for row in heat.rows if row.name == worst.run)
    assert times in [cell.text for cell in row.cells]
    assert "over the noise of the sensor" in heat.caption


def test_39_the_readme_puts_the_command_on_the_path_before_it_is_tried():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    install, tried = readme.index("\n## Install"), readme.index("\n    scdpr demo")
    calls = re.findall(r"^    (.+)$", readme[install:tried], re.MULTILINE)
    assert calls == ["uv tool install .", "pip install ."]
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert re.search(r'^scdpr = "experiments\.cli:main"$', project, re.MULTILINE)


@needs_rig
@pytest.mark.slow
def test_40_a_knock_without_its_time_is_noted(tmp_path, capsys):
    shutil.copytree(RIG, tmp_path / "rig")
    path = tmp_path / "rig" / "0007-pseudo-impulse" / "run.toml"
    path.chmod(0o644)
    text = path.read_text()
    path.write_text(text[: text.index("[knock]")] + text[text.index("[camera]") :])
    main(["check", str(tmp_path / "rig")])
    assert "knock.missing, 0007-pseudo-impulse" in capsys.readouterr().out
