"""Legs planned for rig-a and others, and driven by the engine on robots that differ."""

import concurrent.futures
import functools
import multiprocessing

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.ensemble import Variation
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import rest
from tuning.plan import expectation as expecting
from tuning.plan.at_rate import planned
from tuning.plan.expectation import ROBOTS
from tuning.plan.leg import Leg
from tuning.plan.planning import Wanted, plan_leg, plan_legs, resting_start
from tuning.plan.search.misfit import Misfit
from tuning.plan.search.scenarios import scenarios
from tuning.plan.search.stages import COARSE, FINE, Stage, descend, models, stepped

NUMBERS = {
    "effective_pretension": 85.166460,
    "friction_coefficient": 0.018270845,
    "drive_inertia": 0.014530930,
    "drive_damping": 0.20129864,
}
FITTED = exact(replace(consistent(), NUMBERS))
CONTROLLER = PD(34.46, 1.96)
START, END = (0.3, 0.55), (1.9, 0.55)


@pytest.fixture(scope="module")
def leg():
    return plan_leg(FITTED, CONTROLLER, START, END)


@functools.cache
def misfit(slope=0.0):
    leg = Leg((0.5, 0.7), (1.6, 0.4), 1.0, slope)
    return Misfit(models(FITTED, CONTROLLER, told=False).every, stepped(leg, COARSE))


def random_point(seed, size=2e-3):
    about = misfit()
    return np.random.default_rng(seed).normal(size=about.grid.leg.splines) * size


@given(st.integers(0, 2**31))
@settings(max_examples=10)
def test_the_misfits_derivative_is_its_difference(seed):
    about, point = misfit(), random_point(seed)
    way = random_point(seed + 1, 1e-7)
    difference = (about(point + way).cost - about(point - way).cost) / 2
    # Roundings of a cost of 1e5 come to 1e-10; a carriage that stops a step earlier bends it.
    assert 2 * about(point).gradient @ way == pytest.approx(difference, rel=1e-4, abs=1e-7)


@given(st.integers(0, 2**31))
@settings(max_examples=10)
def test_residuals_and_their_derivatives_have_one_cost(seed):
    about, point = misfit(), random_point(seed)
    assert np.sum(about.rows(point)[:, -1] ** 2) == pytest.approx(about.cost(point), rel=1e-11)


def test_the_plan_leaves_a_twentieth_of_the_plain_legs_vibration(leg):
    assert leg.expected.vibration[0] < leg.plain.vibration[0] / 20
    # The fitted robot, T ± 3 %, friction ± 20 %.
    assert np.all(leg.expected.vibration[:5] < leg.plain.vibration[:5] / 8)


def test_it_rests_at_the_target(leg):
    assert abs(leg.expected.resting[0]) < 0.1e-3 < 1e-3 < abs(leg.plain.resting[0])


def test_the_drives_are_led_from_the_start_to_the_target(leg):
    np.testing.assert_allclose(leg.plan.driven(FITTED)[[0, -1]], [START, END], atol=1e-12)


def test_the_commands_stay_within_the_drives(leg):
    assert np.max(np.abs(leg.plan.feedforward)) < 10.0


def test_a_leg_that_is_too_fast_for_the_drives_takes_longer():
    made = plan_leg(FITTED, CONTROLLER, START, END, leg_time=0.6)
    assert made.asked_time == 0.6
    assert 1.2 < made.leg.time < 2.5
    assert made.expected.vibration[0] < made.plain.vibration[0] / 30


def test_half_of_what_cables_give_is_expected_to_be_unforetold(leg):
    elastic = replace(FITTED, {"drive_compliance": 2e-5})
    made = plan_leg(elastic, CONTROLLER, START, END)
    np.testing.assert_allclose(
        made.plan.angle - made.simulated.angle, made.simulated.angle - leg.plan.angle, atol=1e-9
    )
    assert np.max(np.abs(made.plan.angle - leg.plan.angle)) > 5e-3
    assert made.expected.mean > 1.5 * leg.expected.mean
    np.testing.assert_array_equal(leg.plan.angle, leg.simulated.angle)


def test_a_start_that_is_told_is_begun_at():
    slope = 0.7 * NUMBERS["friction_coefficient"]
    made = plan_leg(FITTED, CONTROLLER, START, END, slope=slope)
    assert scenarios(FITTED, (Variation(),)).slope == [0.0]
    assert made.expected.vibration[0] < made.plain.vibration[0] / 10
    assert abs(made.expected.resting[0]) < 0.2e-3
    begin = made.leg.course.begin
    assert begin[0] == pytest.approx(START[0] + slope * START[1])


def test_where_the_plain_profile_is_expected_to_leave_less_it_is_the_plan(monkeypatch):
    def pessimistic(robots, controller, leg, plan):
        worse = 1.0 if np.any(plan.feedforward) else 0.1
        return expecting.Expectation(np.full(7, worse), np.zeros(7))

    monkeypatch.setattr("tuning.plan.planning.expectation", pessimistic)
    made = plan_leg(FITTED, CONTROLLER, (0.9, 0.5), (1.2, 0.5), leg_time=0.9)
    assert made.is_plain
    assert made.leg.time == 0.9
    assert not np.any(made.plan.feedforward)


@pytest.mark.parametrize(
    ("start", "end", "time", "told"),
    [
        (START, START, 2.0, "leads|leg starts"),
        (START, END, -1.0, "positive"),
        (START, (np.nan, 0.5), 2.0, "finite"),
        (START, END, np.inf, "finite"),
    ],
)
def test_what_is_no_leg_is_refused(start, end, time, told):
    with pytest.raises(ValueError, match=told):
        plan_leg(FITTED, CONTROLLER, start, end, leg_time=time)


@given(
    st.floats(0.3, 1.9), st.floats(0.25, 0.85), st.floats(-0.03, 0.03), st.integers(0, 2**31)
)
def test_a_resting_pose_says_where_a_leg_starts(x, height, slope, seed):
    lower = x + slope * height
    places = map(jnp.asarray, (lower, lower - slope * float(FITTED.frame.height), height))
    position = np.asarray(rest(FITTED, *places).position)
    place, found = resting_start(FITTED, position)
    assert place == pytest.approx((x, height), abs=1e-12)
    assert found == pytest.approx(slope, abs=1e-12)
    noisy = position + np.random.default_rng(seed).normal(size=5) * 1e-4
    place, found = resting_start(FITTED, noisy)
    # Five standard errors: of the mean of three places, and of a slope over 1.1 m.
    assert abs(place[0] - x) < 5e-4
    assert abs(found - slope) < 7e-4


def test_many_legs_are_planned_as_each_alone():
    wanted = [Wanted(START, (0.8, 0.4), 1.2), Wanted((0.8, 0.4), (1.2, 0.5), 0.9, 0.0)]
    many = plan_legs(FITTED, CONTROLLER, wanted)
    alone = plan_leg(FITTED, CONTROLLER, (0.8, 0.4), (1.2, 0.5), leg_time=0.9, slope=0.0)
    np.testing.assert_array_equal(many[1].plan.angle, alone.plan.angle)
    assert len(many) == 2
    spawning = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawning) as processes:
        elsewhere = plan_legs(FITTED, CONTROLLER, wanted, processes=processes)
    for here, there in zip(many, elsewhere, strict=True):
        np.testing.assert_array_equal(here.plan.angle, there.plan.angle)
        assert here.expected.mean == there.expected.mean


def test_the_led_robot_is_that_of_the_closed_loop():
    """Where the motors follow, the reduced model is the engine: to the commands' hold."""
    leg = Leg((0.6, 0.7), (1.3, 0.4), 1.6)
    about = models(FITTED, CONTROLLER, told=False)
    fine = Misfit(about.fitted, stepped(leg, FINE))
    point = descend(fine, np.zeros(leg.splines), Stage(3, 0.0)).point
    run = fine.rehearsed(point)
    plan = planned(FITTED, leg, point, period=1e-3)
    told = expecting.expectation(scenarios(FITTED, ROBOTS), CONTROLLER, leg, plan)
    assert told.resting[0] == pytest.approx(run.arrived[0, -1], abs=6e-5)
    # Millimetres without a plan; the command's hold is worth some hundredths.
    assert told.vibration[0] == pytest.approx(run.vibrations()[0], abs=6e-5)
