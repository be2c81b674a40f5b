"""`scdpr refine`: what a user gives, gets and is told."""

import dataclasses

import leg_rigs
import pytest
from logged_legs import OFF, TRUE, campaign
from tunings import plain

from experiments.cli import main
from experiments.reports.tuning import files
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from identification.campaign.write import write_campaign
from scdpr_jax.robot.quantities import value
from tuning.refinement.refine import Refined
from tuning.result.document import read_tuning, write_tuning
from tuning.result.tuning import FittedSetting

pytestmark = leg_rigs.needs_compiler


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs") / "legs"
    write_campaign(campaign((11, 12, 13)), folder)
    return folder


def tuning(folder, robot):
    """A tuning for a robot at 350 N."""
    path = folder / "tuning.json"
    write_tuning(path, dataclasses.replace(plain(), robots=(FittedSetting(350.0, robot),)))
    return path


def runs(logs):
    return [str(own) for own in sorted(logs.glob("*-leg"))]


def test_the_corrected_tuning_is_nearer_to_the_rig_and_says_so(
    logs, tmp_path, capsys, monkeypatch
):
    # What other programs run is written as after `tune`; printing it takes a minute here.
    monkeypatch.setattr(files, "write_exports", lambda folder, tuning: [folder])
    path = tuning(tmp_path, OFF)
    out = tmp_path / "refined"
    assert main(["refine", str(path), "--run", *runs(logs), "--out", str(out)]) == DONE
    now = read_tuning(out / "tuning.json")
    for name in ("effective_pretension", "upper_friction_coefficient"):
        true, off, own = (
            float(value(robot, name)) for robot in (TRUE, OFF, now.robot_at(350.0).robot)
        )
        assert abs(own - true) < 0.4 * abs(off - true)
    assert "corrected by the logged legs 0001-leg, 0002-leg, 0003-leg" in now.notes[-1]
    told = capsys.readouterr().out
    assert f"wrote {out / 'export'}" in told
    assert f"next: scdpr plan {out / 'tuning.json'}" in told


def test_legs_that_tell_nothing_new_leave_it_as_it_is(logs, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Refined, "helps", False)
    path, out = tuning(tmp_path, TRUE), tmp_path / "refined"
    status = main(["refine", str(path), "--run", *runs(logs), "--out", str(out)])
    assert status == FELL_SHORT
    assert "stays as it is" in capsys.readouterr().out
    assert not out.exists()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["nowhere/0001-leg"], "expected"),
        (["LOGS"], "campaign"),
    ],
)
def test_what_is_no_run_is_refused(logs, tmp_path, capsys, given, message):
    path, out = tuning(tmp_path, OFF), tmp_path / "refined"
    folders = [own.replace("LOGS", str(logs)) for own in given]
    status = main(["refine", str(path), "--run", *folders, "--out", str(out)])
    assert status == BAD_INPUT
    assert message in capsys.readouterr().err
    assert not out.exists()


def test_another_setting_is_named(logs, tmp_path, capsys):
    path = tmp_path / "tuning.json"
    write_tuning(path, dataclasses.replace(plain(), robots=(FittedSetting(200.0, OFF),)))
    arguments = ["refine", str(path), "--run", *runs(logs), "--out", str(tmp_path / "out")]
    assert main(arguments) == BAD_INPUT
    assert "no fitted robot at 350 N" in capsys.readouterr().err


def test_runs_of_two_settings_or_without_a_camera_are_refused(tmp_path, capsys):
    made = campaign((11, 12))
    first, second = made.runs
    other = dataclasses.replace(second, pretension=200.0, pretension_label="200 N")
    blind = dataclasses.replace(second, camera=None)
    for name, own, message in (
        ("settings", other, "have the settings 200 N, 350 N"),
        ("blind", blind, "has no camera.csv"),
    ):
        folder = tmp_path / name
        write_campaign(dataclasses.replace(made, runs=(first, own)), folder)
        path = tuning(tmp_path, OFF)
        out = tmp_path / "out"
        assert main(["refine", str(path), "--run", *runs(folder), "--out", str(out)]) == 2
        assert message in capsys.readouterr().err
