"""Fits that have failed are told from those that noise, or a rig's own ways, leave open."""

import dataclasses
import math

import numpy as np
import report_samples
from hypothesis import given
from hypothesis import strategies as st

from identification.fit.comparison import CAMERA, ENCODERS, Channel
from identification.judge.uncertainty import DOES_NOT_FIT, ParameterEstimate
from identification.judge.verdict import (
    INERTIA_FACTOR,
    SHARE,
    TENS,
    is_doubtful,
    judged,
    unexplained,
)

SEEN = 2e-4 / 0.073
"""Turn of a drive that moves its cable by the camera's noise [rad]."""


def channel(name, ratio, *, share=1.0):
    """A channel whose residual is so many times its noise, and that share of its motion."""
    sigma = 1e-4
    return Channel(name, "m", ratio * sigma, sigma, ratio * sigma / share, 0.5, 60)


def run_of(*channels, held_out=False):
    run = report_samples.comparison("0001-manoeuvre", held_out=held_out)
    return dataclasses.replace(run, channels=channels)


def names(*channels, held_out=False, contradicted=False):
    runs = (run_of(*channels, held_out=held_out),)
    found = unexplained(runs, contradicted=contradicted, seen=SEEN)
    return [one.channel for one in found]


@given(ratio=st.floats(1.01 * TENS, 1e6))
def test_a_camera_that_is_missed_by_tens_of_its_noise_is_not_explained(ratio):
    assert names(channel("x_e", ratio, share=0.01)) == ["x_e"]


@given(name=st.sampled_from((*CAMERA, *ENCODERS)), ratio=st.floats(0.1, 0.99 * TENS))
def test_less_than_tens_of_the_noise_is_no_failure(name, ratio):
    assert names(channel(name, ratio)) == []


@given(share=st.floats(1e-4, 0.99 * SHARE))
def test_counts_of_an_encoder_are_no_failure_of_a_model(share):
    assert names(channel("alpha_1", 5000.0, share=share)) == []
    assert names(channel("alpha_1", 5000.0, share=2 * SHARE)) == ["alpha_1"]


def test_a_drive_that_gives_way_by_less_than_a_camera_sees_is_no_failure():
    assert names(channel("alpha_1", 0.9 * TENS * SEEN / 1e-4, share=10.0)) == []


def test_runs_that_were_held_out_fail_no_fit():
    assert names(channel("x_e", 500.0), held_out=True) == []


def test_with_an_accepted_contradiction_more_than_noise_is_a_failure():
    moderate = channel("x_e", 5.0)
    assert names(moderate, contradicted=True) == ["x_e"]
    assert names(channel("x_e", 1.0), contradicted=True) == []


def test_the_worst_channel_comes_first():
    assert names(channel("x_e", 30.0), channel("y_e", 90.0)) == ["y_e", "x_e"]


def test_a_channel_that_stands_still_has_an_infinite_share():
    still = Channel("alpha_1", "rad", 1.0, 1e-4, 0.0, 0.5, 60)
    (found,) = unexplained((run_of(still),), contradicted=False, seen=SEEN)
    assert math.isinf(found.share)


def test_a_failed_fit_leaves_no_quantity_an_error():
    parameters = report_samples.estimated_parameters()
    fixed = report_samples.parameter("frame_width", 2.0, 0.0, unit="m", status="fixed")
    after = judged((*parameters, fixed), failed=True, contradicted=False)
    assert after[-1] == fixed
    assert {p.status for p in after[:-1]} == {DOES_NOT_FIT}
    assert all(np.isinf(p.sigma) and np.all(np.isinf(p.interval95)) for p in after[:-1])
    assert [p.value for p in after[:-1]] == [p.value for p in parameters]


def test_what_rests_on_an_accepted_contradiction_is_weak_at_best():
    parameters = report_samples.estimated_parameters()
    after = judged(parameters, failed=False, contradicted=True)
    assert {p.status for p in after} == {"weak"}
    assert [p.interval95 for p in after] == [p.interval95 for p in parameters]


def test_a_good_fit_stays_as_it_is():
    parameters = report_samples.estimated_parameters()
    assert judged(parameters, failed=False, contradicted=False) == parameters


def test_what_the_rank_leaves_open_has_no_interval_however_small_its_error():
    parameters = report_samples.estimated_parameters()
    open_ = frozenset({(parameters[0].name, parameters[0].setting)})
    after = judged(parameters, failed=False, contradicted=False, open_by_rank=open_)
    assert after[0].status == "unidentifiable"
    assert np.isinf(after[0].sigma)
    assert after[1:] == parameters[1:]


@given(ratio=st.floats(1.01 * INERTIA_FACTOR, 50.0), over=st.booleans())
def test_an_inertia_that_no_rotor_has_makes_a_fit_with_more_than_noise_doubtful(ratio, over):
    nameplate = 0.0127
    value = nameplate * ratio if over else nameplate / ratio
    inertia = report_samples.parameter("drive_inertia", value, 1e-6, unit="kg m^2")
    noisy, quiet = run_of(channel("x_e", 5.0)), run_of(channel("x_e", 1.0))
    assert is_doubtful((inertia,), (noisy,), nameplate=nameplate)
    assert not is_doubtful((inertia,), (quiet,), nameplate=nameplate)
    assert not is_doubtful((inertia,), (noisy,), nameplate=value / 1.5)


def test_what_goes_along_with_an_open_combination_is_known_no_better_than_that():
    inertia = ParameterEstimate(
        "drive_inertia", None, 0.016, "kg m^2", 1e-6, (0.016, 0.016), "identified"
    )
    key = ("drive_inertia", None)
    (widened,) = judged([inertia], failed=False, contradicted=False, left_open={key: 0.05})
    assert widened.status == "identified"
    assert math.isclose(widened.sigma, 0.05 * 0.016, rel_tol=1e-3)
    low, high = widened.interval95
    assert low < 0.0150 < 0.0170 < high
    (weak,) = judged([inertia], failed=False, contradicted=False, left_open={key: 0.3})
    assert weak.status == "weak"
