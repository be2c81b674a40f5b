"""Forty mistakes of a new user: each is one message with what, where, expected and remedy.

By the numbers of `shared/data/mistakes.md`. Elsewhere: 8 and 10 (logs of any make and
`run.toml`, `test_faults`), 12 (`test_identification/doctor`), 23 (`test_identify_drive`), 30
and 31 (`test_identification/bring`), 36 and 37 (`test_terminal`); the rest is in
`test_mistakes_elsewhere`.
"""

import json
import os
import pathlib
import re
import shutil

import good_campaign
import numpy as np
import pytest
from mistakes import spoil, told
from tunings import plain

import scdpr_jax
from experiments.cli import main
from experiments.verbs.study import sweep
from identification.campaign.abbreviation import full_names
from scdpr_jax.robot.quantities import QUANTITIES
from tuning.result.document import write_tuning
from tuning.shapers.spectrum_file import read_spectrum

RIG = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns" / "rig-a"
needs_rig = pytest.mark.skipif(not RIG.is_dir(), reason="the reference campaign is absent")
ROBOT = scdpr_jax.consistent()
LEG = ("--from", "0.3 m, 0.55 m", "--to", "1.9 m, 0.55 m")


@pytest.fixture
def rig(tmp_path):
    """A small campaign, the one in the folder `lab`."""
    return good_campaign.write(tmp_path / "lab" / "rig")


def row(quantity):
    """A quantity of the prototype as parameters.json has it."""
    setting = "350 N" if quantity.name == "effective_pretension" else None
    value = float(scdpr_jax.value(ROBOT, quantity.name))
    fixed = {"sigma": None, "interval95": [None, None], "status": "fixed"}
    of = {"name": quantity.name, "setting": setting, "value": value, "unit": quantity.unit}
    return of | fixed


@pytest.fixture
def made(tmp_path):
    """A tuning.json and a parameters.json."""
    tuning, parameters = tmp_path / "tuning.json", tmp_path / "parameters.json"
    write_tuning(tuning, plain())
    parameters.write_text(json.dumps({"format": 1, "parameters": list(map(row, QUANTITIES))}))
    return tuning, parameters


def test_01_the_campaign_that_is_meant_is_named(rig, tmp_path, capsys):
    for place in (rig.parent, rig / "0001-step", rig / "campaign.toml"):
        message = told(capsys, "calibrate", place, "--out", tmp_path / "out")
        assert f"{place}: " in message
        assert "expected a folder with campaign.toml" in message
        assert f"{rig}" in message.rpartition("name ")[2]


@pytest.mark.parametrize("verb", ["calibrate", "identify", "frequencies"])
def test_02_a_file_for_the_results_folder_is_told_before_anything_is_read(
    verb, tmp_path, capsys
):
    (tmp_path / "out").touch()
    message = told(capsys, verb, tmp_path / "nowhere", "--out", tmp_path / "out")
    assert f"`--out`: {tmp_path / 'out'}" in message
    assert "got a file in its folder's place, expected a folder" in message
    assert "Name another one" in message


def test_02_of_shape_too(tmp_path, capsys):
    (tmp_path / "out").touch()
    message = told(capsys, "shape", "s.csv", "--out", tmp_path / "out")
    assert "got a file in its folder's place, expected a folder" in message


def test_03_what_stands_for_one_name_is_taken_and_for_several_is_told(rig, tmp_path, capsys):
    runs = ("0004-step", "0005-step", "0055-knock")
    options = {"argument": "--hold-out", "what": "run"}
    assert full_names(("0005", "knock"), runs, **options) == ("0005-step", "0055-knock")
    with pytest.raises(ValueError, match="more than one run, got '00', expected one of: 00"):
        full_names(("00",), runs, **options)
    call = ("identify", rig, "--out", tmp_path / "out")
    message = told(capsys, *call, "--hold-out", "7")
    assert "no such run, got '7', expected one of: 0001-step, 0002-knock. Give" in message
    assert "`--free`: no such quantity, got 'nu'" in told(capsys, *call, "--free", "nu")


def test_04_the_option_that_is_meant_is_named(capsys):
    message = told(capsys, "identify", "rig", "--output", "out")
    assert "no option '--output', expected one of: " in message
    assert message.endswith("Did you mean `--out`?")


def test_06_results_in_a_campaign_are_refused(rig, capsys):
    message = told(capsys, "identify", rig, "--out", rig / "results")
    assert "`--out` must be outside the campaign" in message
    assert "Name another folder." in message


def test_07_the_remedy_has_the_files_own_units(rig, capsys):
    drive = rig / "0001-step" / "drive.csv"
    drive.write_text(drive.read_text().replace(",", ";").replace(".", ","))
    message = told(capsys, "check", rig)
    assert "0001-step/drive.csv, row 1: columns separated by semicolons" in message
    assert "Export the log again with these separators: t [ms],voltage_1 [mV]" in message


def test_09_a_knock_on_another_clock_is_told_with_both_times(rig, capsys):
    drive = rig / "0002-knock" / "drive.csv"
    header, *rows = drive.read_text().splitlines()
    late = [f"{1.7e12 + n:.0f},{row.split(',', 1)[1]}" for n, row in enumerate(rows)]
    drive.write_text("\n".join([header, *late]) + "\n")
    message = told(capsys, "check", rig)
    assert "expected 1700000000.000 s to 1700000000.003 s on the drive's clock" in message
    assert "counts from 1970; or take its first time off" in message


def test_13_a_start_that_is_not_known_is_noted(rig, capsys):
    spoil(rig / "0001-step" / "run.toml", '[initial]\nx_e = "173 mm"\ny_e = "0.300 m"\n', "")
    (rig / "0001-step" / "camera.csv").unlink()
    assert main(["check", str(rig)]) in (0, 1)
    out = " ".join(capsys.readouterr().out.split())
    assert "where the robot starts is unknown" in out
    assert "Add `[initial]` with x_e and y_e to run.toml" in out


def test_14_a_run_of_three_rows_is_noted(rig, capsys):
    drive = rig / "0001-step" / "drive.csv"
    drive.write_text("\n".join(drive.read_text().splitlines()[:4]) + "\n")
    main(["check", str(rig)])
    assert "a run of 3 samples, 0.002 s" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('{\n "format": 1,\n "parameters": [\n', "the file is cut, got its end in row 3"),
        ("", "the file is empty, got no text"),
        ('{"format": 2}', "format is wrong, got 2"),
        ("x,y\n1,2\n", "row 1 isn't JSON, got 'x,y'"),
        ('{"a": 1}', "format is missing, got no such key"),
    ],
)
def test_15_a_file_that_is_none_is_told_in_words(content, message, tmp_path, capsys):
    path = tmp_path / "parameters.json"
    path.write_text(content)
    text = told(capsys, "simulate", "--parameters", path, "--out", tmp_path / "out")
    assert f"{path}: {message}" in text
    assert "Expected what `scdpr identify` writes; write it anew." in text
    assert not any(word in text for word in ("b'", "Field required", "Input should"))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"value": -0.1}, "can't be a robot's, got -0.1"),
        ({"value": 1e9}, "can't be a robot's, got 1e+09"),
        ({"value": "0.01"}, "got '0.01': it should be a valid number"),
    ],
)
def test_16_numbers_of_no_robot_are_refused(change, message, made, tmp_path, capsys):
    document = json.loads(made[1].read_text())
    document["parameters"][0].update(change)
    made[1].write_text(json.dumps(document))
    call = ("simulate", "--parameters", made[1], "--out", tmp_path / "out")
    assert message in told(capsys, *call)


@pytest.mark.parametrize(
    ("name", "value"), [("proportional_gain", -5.0), ("period", 0.0), ("period", "1 ms")]
)
def test_17_gains_of_no_controller_are_refused(name, value, made, tmp_path, capsys):
    document = json.loads(made[0].read_text())
    document["controller"][name]["value"] = value
    made[0].write_text(json.dumps(document))
    text = told(capsys, "plan", made[0], *LEG, "--out", tmp_path / "plan.csv")
    assert f"controller.{name}.value is wrong, got {value!r}: it should be" in text
    assert "write it anew" in text


def test_18_a_file_for_another_is_recognised(made, tmp_path, capsys):
    tuning, parameters = made
    text = told(capsys, "simulate", "--parameters", tuning, "--out", tmp_path / "out")
    assert "got a tuning.json, which `scdpr plan` takes, expected a parameters.json" in text
    text = told(capsys, "plan", parameters, *LEG, "--out", tmp_path / "plan.csv")
    assert "got a parameters.json, which `scdpr tune` takes, expected a tuning.json" in text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("--from", "0.3, 0.55"), "`--from`: a number without its unit, got '0.3'"),
        (("--to", "9 m, 0.5 m"), "`--to` is outside of the frame, got x = 9 m"),
        (("--to", "0.3 m, 0.55 m"), "the same place as the start"),
        (("--setting", "500 N"), "no fitted robot at 500 N"),
    ],
)
def test_19_a_leg_that_is_none_is_refused(change, message, made, tmp_path, capsys):
    place = dict(zip(LEG[::2], LEG[1::2], strict=True)) | {change[0]: change[1]}
    words = [word for pair in place.items() for word in pair]
    text = told(capsys, "plan", made[0], *words, "--out", tmp_path / "plan.csv")
    assert message in text
    assert not (tmp_path / "plan.csv").exists()


def test_20_a_folder_for_a_plan_is_told_at_once(made, tmp_path, capsys):
    (tmp_path / "plans").mkdir()
    text = told(capsys, "plan", made[0], *LEG, "--out", tmp_path / "plans")
    assert f"`--out`: got {tmp_path / 'plans'}, a folder, expected a file. Name one in" in text


MANY = tuple(f"{name}=0.2..0.9:3000000 m" for name in ("x", "y"))


@pytest.mark.parametrize(
    ("over", "out", "message"),
    [
        (("y=0.2..0.9:3 m",), "o.csv", "expected a netCDF file, such as"),
        (MANY, "o.nc", "Take fewer points, or name a larger disk."),
        (("y=5..6:5 m",), "o.nc", "y is nowhere in the frame, got 5 to 6 m, expected values"),
    ],
    ids=["table", "many", "outside"],
)
def test_21_a_sweep_that_cannot_be_is_refused(
    over, out, message, tmp_path, capsys, monkeypatch
):
    # The process has its devices already.
    monkeypatch.setattr(sweep, "set_up", lambda **options: None)
    text = told(capsys, "sweep", "frequency", "--over", *over, "--out", tmp_path / out)
    assert message in text
    assert not (tmp_path / out).exists()


def test_22_metres_under_millimetres_are_told_before_the_fit(tmp_path, capsys):
    time = 1e-3 * np.arange(2000)
    metres = 0.1 * np.sin(2 * np.pi * time)
    volts = -50 * (2 * np.pi) ** 2 * metres / 35.0
    rows = np.column_stack([time, volts, metres])
    log = tmp_path / "axis.csv"
    lines = [",".join(f"{number:.9f}" for number in row) for row in rows]
    log.write_text("\n".join(["t [s],voltage [V],position [mm]", *lines]) + "\n")
    call = ("identify-drive", log, "--gain", "35 N/V", "--out", tmp_path / "out")
    text = told(capsys, *call)
    assert re.search(r"accelerations make the axis [5-9e+.0-9]+ kg, expected 0.0001 to", text)
    assert "of `position` (metres under [mm] a thousandfold)" in text


@pytest.mark.parametrize("unit", ["Hz", "kHz", "rad/s"])
def test_24_a_spectrums_units_are_read(unit, tmp_path):
    scale = {"Hz": 1.0, "kHz": 1e-3, "rad/s": 2 * np.pi}[unit]
    frequency = np.linspace(1, 100, 100)
    power = np.exp(-((frequency - 45) ** 2) / 20) * frequency
    for column, numbers in (("psd_xyz", power), ("psd_xyz [dB]", 10 * np.log10(power + 1e-9))):
        lines = [f"{f * scale:.9g},{p:.9g}" for f, p in zip(frequency, numbers, strict=True)]
        path = tmp_path / "spectrum.csv"
        path.write_text("\n".join([f"freq [{unit}],{column}", *lines]) + "\n")
        assert read_spectrum(path).spectrum.peak == pytest.approx(45.0, abs=0.6)


def test_25_milliseconds_are_offered(tmp_path, capsys):
    text = told(capsys, "shape", "s.csv", "--max-duration", "20", "--out", tmp_path / "out")
    assert "`--max-duration`: a number without its unit, got '20', expected a time [s]" in text
    assert 'Write it like "20 ms" or "0.02 s".' in text


def test_26_both_verbs_take_the_same_symbols():
    names = ("friction_coefficient", "drive_inertia")
    for argument in ("--free", "--for"):
        full = full_names(("mu", "J"), names, argument=argument, what="quantity")
        assert full == names


def test_34_a_pipe_and_a_device_are_no_files(rig, made, tmp_path, capsys):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    drive = rig / "0001-step" / "drive.csv"
    drive.unlink()
    os.mkfifo(drive)
    text = told(capsys, "check", rig)
    assert "0001-step/drive.csv: the file can't be read, got a pipe, expected a file" in text
    for kind, call in (
        ("pipe", ("identify-drive", fifo, "--gain", "35 N/V", "--out", tmp_path / "out")),
        ("device", ("shape", "/dev/zero", "--out", tmp_path / "out")),
        ("pipe", ("plan", fifo, *LEG, "--out", tmp_path / "plan.csv")),
        (
            "pipe",
            ("tune", "--parameters", made[1], "--frequencies", fifo, "--out", tmp_path / "out"),
        ),
    ):
        assert f"got a {kind}, expected a file" in told(capsys, *call)


def test_34_a_link_out_of_the_campaign_is_refused(rig, tmp_path, capsys):
    drive = rig / "0001-step" / "drive.csv"
    shutil.copy(drive, tmp_path / "log.csv")
    drive.unlink()
    drive.symlink_to(tmp_path / "log.csv")
    assert "0001-step/drive.csv" in told(capsys, "check", rig)
