"""What a fit sees of a campaign: runs that begin in motion marked, and runs in pieces."""

import dataclasses

import numpy as np
import planted_slips
import pytest
import slip_changes

from identification.doctor.examine import diagnosis
from identification.doctor.fittable import fittable


def seen(campaign):
    return fittable(campaign, diagnosis(campaign))


def changed(campaign, change, name):
    return planted_slips.each_run(campaign, change, [name])


def gap(begin, end):
    """A logger that lost the samples between two instants."""

    def change(run):
        keep = (run.drive.time < begin) | (run.drive.time >= end)
        drive = run.drive
        return slip_changes.drive(
            run, time=drive.time[keep], voltage=drive.voltage[keep], angle=drive.angle[keep]
        )

    return change


def test_a_good_campaign_is_fitted_as_it_is(good):
    fitted = seen(good[1])
    assert fitted.skipped == ()
    assert [run.name for run in fitted.runs] == [run.name for run in good[1].runs]
    for run, was in zip(fitted.runs, good[1].runs, strict=True):
        assert run.drive is was.drive


def unfilmed(run):
    return dataclasses.replace(run, camera=None)


def test_a_run_that_begins_in_motion_is_fitted_as_one(good):
    name = planted_slips.steps(good[1])[0]
    fitted = seen(changed(good[1], planted_slips.cut, name))
    assert [run.name for run in fitted.runs if run.in_motion] == [name]
    assert fitted.skipped == ()


def test_one_that_no_camera_sees_begin_is_left_out_with_the_reason(good):
    name = planted_slips.steps(good[1])[0]
    moving = changed(good[1], planted_slips.cut, name)
    fitted = seen(changed(moving, unfilmed, name))
    assert name not in {run.name for run in fitted.runs}
    [(left, [fault])] = fitted.skipped
    assert left == name
    assert "doesn't begin at rest" in str(fault)
    assert "turns at" in str(fault)
    assert "no camera sees how it begins" in str(fault)


def test_a_run_with_a_gap_is_two_pieces(good):
    name = planted_slips.manoeuvres(good[1])[0]
    fitted = seen(changed(good[1], gap(0.9, 1.1), name))
    first, second = fitted.run(name), fitted.run(f"{name}, piece 2")
    assert first.drive.time[-1] < 0.9
    assert first.camera.time[-1] <= 0.9
    assert not first.in_motion
    assert second.drive.time[0] >= 1.1
    assert second.in_motion
    assert fitted.skipped == ()


def test_a_piece_after_a_knock_is_no_knock(good):
    name = planted_slips.knocked(good[1])[0]
    fitted = seen(changed(good[1], gap(0.9, 1.0), name))
    second = fitted.run(f"{name}, piece 2")
    assert fitted.run(name).knock is not None
    assert (second.kind, second.knock) == ("free", None)


def test_a_piece_that_begins_at_rest_is_a_run_of_its_own(good):
    # The manoeuvre dwells between its legs, and begins 0.2 s after its first sample.
    name = planted_slips.manoeuvres(good[1])[0]
    fitted = seen(changed(good[1], gap(0.02, 0.08), name))
    [first, second] = [(left, fault) for left, (fault,) in fitted.skipped], fitted.runs
    assert [left for left, _ in first] == [name]
    assert "shorter than 0.3 s" in str(first[0][1])
    piece = next(run for run in second if run.name == f"{name}, piece 2")
    assert piece.drive.time[0] >= 0.08
    assert piece.initial is None
    assert np.all(piece.camera.time >= 0.08)


def test_a_campaign_of_nothing_but_untold_motion_is_refused(good):
    name = planted_slips.steps(good[1])[0]
    moving = changed(changed(good[1], planted_slips.cut, name), unfilmed, name)
    alone = dataclasses.replace(moving, runs=(moving.run(name),))
    with pytest.raises(ValueError, match="no run is left to fit, got 1"):
        seen(alone)
