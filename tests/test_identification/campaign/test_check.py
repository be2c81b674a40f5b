import dataclasses
import pathlib

import good_campaign
import numpy as np
import pytest

from identification.campaign.check import RunSummary, campaign_notes, check_campaign
from identification.campaign.types import (
    CameraStream,
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
    encoder_resolution,
)

SHARED = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
COUNTS = 26624.0


def quiet_run():
    """A run in which nothing is worth a note."""
    time = np.arange(1000) / 1000
    volts = np.where(time >= 0.2, 5.0, 0.0)
    counts = np.rint(np.where(time > 0.2, 4000 * (time - 0.2), 0.0))
    frames = np.arange(30) / 30
    away = np.where(frames > 0.25, 0.1 * (frames - 0.25), 0.0)
    zero = np.zeros_like(away)
    return Run(
        name="0001-step",
        kind="torque_step",
        pretension=350.0,
        pretension_label="350 N",
        initial=Initial(x_e=0.5, y_e=0.3),
        drive=DriveStream(
            time=time,
            voltage=np.stack([volts, volts], axis=-1),
            angle=np.stack([counts, counts], axis=-1) * encoder_resolution(COUNTS),
        ),
        camera=CameraStream(
            time=frames,
            position=np.stack([0.5 + away, zero, 0.5 + away, 0.5 + away, 0.3 + zero], axis=-1),
        ),
    )


def notes_of(run, robot=None):
    return campaign_notes(
        Campaign(name="rig", counts_per_rev=COUNTS, runs=(run,), robot=robot or {})
    )


def drive(**changes):
    return lambda run: dataclasses.replace(
        run, drive=dataclasses.replace(run.drive, **{k: v(run) for k, v in changes.items()})
    )


def camera(**changes):
    return lambda run: dataclasses.replace(
        run, camera=dataclasses.replace(run.camera, **{k: v(run) for k, v in changes.items()})
    )


def changed(array, places, value):
    array = array.copy()
    array[places] = value
    return array


def without_rows(stream, rows):
    keep = np.setdiff1d(np.arange(len(stream.time)), rows)
    arrays = {
        name: getattr(stream, name)[keep]
        for name in ("time", "voltage", "angle", "position")
        if hasattr(stream, name)
    }
    return dataclasses.replace(stream, **arrays)


def steady(value):
    return lambda run: np.full_like(run.drive.voltage, value)


LOST = ([3, 4, 9], [2, 2, 4])  # q_3 in two frames, y_e in one

NOTES = [
    (
        drive(extra=lambda run: {"air [degC]": run.drive.time}),
        "drive.csv",
        "columns that are kept and ignored: air [degC]",
    ),
    (
        lambda run: dataclasses.replace(run, drive=without_rows(run.drive, [500, 501])),
        "drive.csv",
        "irregular sampling: 0.1 % of the steps are off the period of 1 ms, "
        "one of 3 ms at t = 0.499 s",
    ),
    (
        drive(voltage=lambda run: run.drive.voltage * 2),
        "drive.csv",
        "voltage clipped at the limit of the paper's rig, 10 V, in 80 % of the samples",
    ),
    (
        drive(angle=lambda run: run.drive.angle * np.array([1, 0.001])),
        "drive.csv",
        "encoder counts not resolved: `alpha_2` moves by 3.2 counts of 0.236 mrad",
    ),
    (
        drive(voltage=lambda run: 5 + 0 * run.drive.voltage),
        "drive.csv",
        "no rest at the start: the first command comes after 0 ms",
    ),
    (
        drive(angle=lambda run: changed(run.drive.angle, (slice(50), 0), -0.01)),
        "drive.csv",
        "moves before anything is commanded: a pulley turns by 10 mrad before t = 0.2 s",
    ),
    (
        camera(position=lambda run: changed(run.camera.position, (slice(1, 3), 4), 0.303)),
        "camera.csv",
        "moves before anything is commanded: the end-effector moves by 3 mm before t = 0.2 s",
    ),
    (
        drive(voltage=lambda run: 0 * run.drive.voltage),
        "drive.csv",
        "nothing is commanded in the whole run, and a pulley turns by 0.754 rad",
    ),
    (lambda run: dataclasses.replace(run, camera=None), "0001-step", "no camera.csv"),
    (
        lambda run: dataclasses.replace(run, camera=without_rows(run.camera, [10, 11, 20])),
        "camera.csv",
        "3 frames dropped in 2 gaps, the longest of 100 ms at t = 0.3 s",
    ),
    (
        camera(
            position=lambda run: changed(run.camera.position, ([3, 4, 9], [2, 2, 4]), np.nan)
        ),
        "camera.csv",
        "markers lost: q_3 in 2 of 30 frames, y_e in 1 of 30 frames",
    ),
    (
        lambda run: dataclasses.replace(run, clock_offset=None),
        "run.toml",
        'the camera\'s clock offset is "unknown"',
    ),
    (
        camera(position=lambda run: changed(run.camera.position, (29, 0), 2.3)),
        "camera.csv",
        "the end-effector is outside the frame of 2.224 m by 1.112 m in 3.3 % of the frames",
    ),
    (
        lambda run: dataclasses.replace(run, initial=Initial(x_e=0.49, y_e=0.3)),
        "run.toml",
        "[initial] is 10 mm off what the camera sees first, with a placement_sigma of 1 mm",
    ),
]


def test_a_run_as_it_should_be_gets_no_note():
    assert notes_of(quiet_run()) == ()


@pytest.mark.parametrize(("change", "file", "what"), NOTES)
def test_what_is_worth_knowing_is_noted_with_file_cause_and_remedy(change, file, what):
    notes = [note for note in notes_of(change(quiet_run())) if note.what.startswith(what)]
    assert len(notes) == 1
    assert notes[0].file.endswith(file)
    assert str(notes[0]) == (
        f"{notes[0].file}: {notes[0].what}. {notes[0].cause} {notes[0].remedy}"
    )


TOLD_BY_THE_DOCTOR = (
    drive(voltage=lambda run: run.drive.voltage * 3),
    drive(angle=lambda run: changed(run.drive.angle, (slice(600, None), 1), 15.0)),
    lambda run: dataclasses.replace(run, drive=without_rows(run.drive, range(500, 510))),
    lambda run: dataclasses.replace(run, camera=without_rows(run.camera, range(10, 20))),
    lambda run: dataclasses.replace(run, initial=Initial(x_e=0.05, y_e=0.3)),
    camera(position=lambda run: run.camera.position * 1e3),
)


@pytest.mark.parametrize("change", TOLD_BY_THE_DOCTOR)
def test_what_the_doctor_tells_is_not_noted_again(change):
    assert notes_of(change(quiet_run())) == ()


def test_a_stated_voltage_limit_is_the_one_that_counts():
    (note,) = notes_of(quiet_run(), {"voltage_limit": 5.0})
    assert note.what.startswith("voltage clipped at the limit of [robot], 5 V")


def test_a_knock_is_where_the_motion_may_begin():
    run = quiet_run()
    still = np.zeros_like(run.drive.voltage)
    knocked = dataclasses.replace(
        drive(voltage=lambda _: still)(run),
        kind="pseudo_impulse",
        knock=Knock(start=0.2, duration=0.03),
    )
    assert notes_of(knocked) == ()


def test_a_bare_drive_needs_no_camera():
    run = dataclasses.replace(quiet_run(), kind="motor_step", camera=None)
    assert notes_of(run) == ()


def test_the_same_note_of_several_runs_is_told_once():
    run = dataclasses.replace(quiet_run(), clock_offset=None)
    other = dataclasses.replace(run, name="0002-step")
    campaign = Campaign(name="rig", counts_per_rev=COUNTS, runs=(run, other))
    (note,) = campaign_notes(campaign)
    assert note.file == "0001-step/run.toml and 1 more"


def test_the_doctor_sums_up_every_run_good_and_bad(tmp_path):
    folder = good_campaign.write(tmp_path / "small")
    (folder / "0002-knock" / "drive.csv").unlink()
    check = check_campaign(folder)
    assert not check.passed
    assert [fault.what for fault in check.faults] == ["the file is missing"]
    assert check.runs == (
        RunSummary(
            name="0001-step",
            kind="torque_step",
            pretension=350.0,
            duration=0.003,
            rows=4,
            camera_rows=3,
        ),
        RunSummary(name="0002-knock"),
    )
    assert any("0001-step" in note.file for note in check.notes)


def test_the_doctor_sees_a_folder_that_is_not_there(tmp_path):
    check = check_campaign(tmp_path / "none")
    assert (check.passed, check.runs, check.notes) == (False, (), ())


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared campaigns are absent")
def test_the_doctor_knows_what_the_second_rig_has_and_the_first_has_not():
    first, second = (check_campaign(SHARED / rig) for rig in ("rig-a", "rig-b"))
    assert first.passed
    assert second.passed
    assert len(first.runs) == len(second.runs) == 14
    told = [note.what for note in second.notes]
    for what in ("frames dropped", "markers lost", '"unknown"', "moves before anything"):
        assert any(what in note for note in told)
        assert not any(what in note.what for note in first.notes)
