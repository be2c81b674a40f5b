"""Starts in motion are told, and starts at rest that look like it are not."""

import dataclasses

import numpy as np
import planted_slips
import slip_changes

from identification.campaign import Campaign, Run
from identification.doctor import examine


def late(begin: float):
    """The logger was started late."""

    def change(run: Run) -> Run:
        rows = run.drive.time >= begin
        drive = run.drive
        run = slip_changes.drive(
            run,
            time=drive.time[rows],
            voltage=drive.voltage[rows],
            angle=drive.angle[rows],
        )
        frames = run.camera.time >= begin
        return slip_changes.camera(
            run, time=run.camera.time[frames], position=run.camera.position[frames]
        )

    return change


def moving(campaign: Campaign) -> set[str]:
    return {
        name
        for finding in examine(campaign)
        if finding.id == "start.moving"
        for name in finding.runs
    }


def test_a_run_cut_while_its_drives_turn_is_told(good):
    names = planted_slips.steps(good[0])[:3]
    for begin in (0.2, 0.7):
        cut = planted_slips.each_run(good[0], late(begin), names[:2])
        assert moving(cut.with_runs(names)) == set(names[:2])


def test_a_run_that_is_commanded_from_its_first_row_on_begins_at_rest(good):
    names = planted_slips.steps(good[0])[:4]
    voltage = good[0].run(names[0]).drive.voltage
    first = float(good[0].run(names[0]).drive.time[np.argmax(np.abs(voltage[:, 0]) > 0.05)])
    cut = planted_slips.each_run(good[0], late(first), names)
    assert moving(cut.with_runs(names)) == set()


def test_an_end_effector_that_swings_while_its_drives_rest_is_told(good):
    name = next(run.name for run in good[1].runs if run.kind == "breakaway")

    def ringing(run: Run) -> Run:
        position = run.camera.position.copy()
        since = run.camera.time
        position[:, 0] += 4e-3 * np.exp(-since) * np.cos(20 * since)
        return dataclasses.replace(
            run, camera=dataclasses.replace(run.camera, position=position)
        )

    assert moving(planted_slips.each_run(good[1], ringing, [name])) == {name}
