import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from short_runs import bare_run

from identification.data.circumstances import (
    CLOCK,
    MOVING,
    NAMES,
    START,
    Circumstances,
    open_circumstances,
    prior,
)
from identification.data.start import USUAL_ARM, USUAL_DRIFT, Clock, Start

SEEN = Start(np.array([0.3, 0.31, 0.5]), np.array([1e-4, 2e-4, 3e-4]), 0.2)


def of(vector):
    return dict(zip(NAMES, np.asarray(vector), strict=True))


@given(st.lists(st.floats(-1e3, 1e3), min_size=len(NAMES), max_size=len(NAMES)))
def test_circumstances_come_back_from_their_vector(numbers):
    circumstances = Circumstances.of(np.array(numbers))
    np.testing.assert_array_equal(circumstances.vector, numbers)
    assert [float(getattr(circumstances, name)) for name in NAMES] == numbers


def test_every_circumstance_moves_the_robot_or_is_the_cameras_clock():
    assert (*NAMES[MOVING], *NAMES[CLOCK]) == NAMES
    assert NAMES[START] == ("lower", "upper", "height")
    assert NAMES[CLOCK] == ("clock_offset", "clock_drift")


@pytest.mark.parametrize("name", NAMES)
def test_every_circumstance_states_its_unit(name):
    (field,) = (f for f in dataclasses.fields(Circumstances) if f.name == name)
    assert f"[{field.metadata['unit']}]" in {"[m]", "[N]", "[s]", "[1]"}


def test_an_unknown_clock_is_open_and_a_stated_one_is_not():
    run = bare_run("torque_step")
    unknown = dataclasses.replace(run, clock_offset=None)
    assert not of(open_circumstances(run, clock_drifts=False))["clock_offset"]
    assert of(open_circumstances(unknown, clock_drifts=False))["clock_offset"]


def test_what_is_stated_exactly_or_not_known_at_all_has_no_prior():
    known = prior(bare_run("torque_step"), SEEN, Clock(0.0, 0.0), clock_drifts=False)
    weight = of(known.weight)
    assert [name for name in NAMES if weight[name] > 0] == list(NAMES[START])
    np.testing.assert_allclose(known.mean[START], SEEN.position)


def test_a_knocks_arm_and_a_drift_are_about_zero_as_far_as_is_usual():
    knocked = prior(bare_run("pseudo_impulse"), SEEN, Clock(0.01, 0.0), clock_drifts=True)
    weight = of(knocked.weight)
    assert weight["knock"] == 0.0
    assert weight["knock_arm"] == pytest.approx(1 / USUAL_ARM)
    assert weight["clock_drift"] == pytest.approx(1 / USUAL_DRIFT)


def test_a_drifting_clocks_offset_is_known_less_well_at_the_runs_first_row():
    clock, run = Clock(0.01, 1e-3), bare_run("torque_step")
    steady, drifting = (
        of(prior(run, SEEN, clock, clock_drifts=drifts).weight)["clock_offset"]
        for drifts in (False, True)
    )
    assert steady == pytest.approx(1e3)
    length = run.drive.time[-1]
    assert drifting == pytest.approx(1 / np.hypot(1e-3, USUAL_DRIFT * length / 2))


def test_residuals_of_a_prior_are_in_its_standard_deviations():
    known = prior(bare_run("torque_step"), SEEN, Clock(0.0, 0.0), clock_drifts=False)
    start = SEEN.position + np.array([2.0, -1.0, 0.5]) * SEEN.sigma
    residuals = known.residuals(Circumstances(*start, 7.0, 7.0, 7.0, 7.0))
    np.testing.assert_allclose(residuals[START], [-2.0, 1.0, -0.5], rtol=1e-9)
    np.testing.assert_array_equal(residuals[START.stop :], 0.0)
