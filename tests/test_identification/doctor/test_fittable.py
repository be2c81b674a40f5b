"""What a fit sees of a campaign: no run that begins in motion, and runs in pieces."""

import dataclasses

import numpy as np
import planted_slips
import pytest

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
        return planted_slips.drive(
            run, time=drive.time[keep], voltage=drive.voltage[keep], angle=drive.angle[keep]
        )

    return change


def test_a_good_campaign_is_fitted_as_it_is(good):
    fitted = seen(good[1])
    assert fitted.skipped == ()
    assert [run.name for run in fitted.runs] == [run.name for run in good[1].runs]
    for run, was in zip(fitted.runs, good[1].runs, strict=True):
        assert run.drive is was.drive


def test_a_run_that_begins_in_motion_is_left_out_with_the_reason(good):
    name = planted_slips.steps(good[1])[0]
    fitted = seen(changed(good[1], planted_slips.cut, name))
    assert name not in {run.name for run in fitted.runs}
    [(left, [fault])] = fitted.skipped
    assert left == name
    assert "doesn't begin at rest" in str(fault)
    assert "turns at" in str(fault)


def test_a_run_with_a_gap_is_fitted_up_to_it(good):
    name = planted_slips.manoeuvres(good[1])[0]
    fitted = seen(changed(good[1], gap(0.9, 1.1), name))
    run = fitted.run(name)
    assert run.drive.time[-1] < 0.9
    assert run.camera.time[-1] <= 0.9
    [(left, [fault])] = fitted.skipped
    assert left == f"{name}, piece 2"
    assert "begins in motion" in str(fault)


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


def test_a_campaign_of_nothing_but_motion_is_refused(good):
    name = planted_slips.steps(good[1])[0]
    moving = changed(good[1], planted_slips.cut, name)
    alone = dataclasses.replace(moving, runs=(moving.run(name),))
    with pytest.raises(ValueError, match="no run is left to fit, got 1"):
        seen(alone)
