"""The whole of tuning: on a rig whose parameters are known, and on rigs of another program."""

import types

import leg_rigs
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.share import share, worse
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune
from tuning.loop.admissible import PEAK_SENSITIVITY, PHASE_MARGIN

PLAIN = published_pd()
RIG_A = exact(
    replace(
        consistent(),
        {
            "effective_pretension": 85.166460,
            "friction_coefficient": 0.018270845,
            "drive_inertia": 0.014530930,
            "drive_damping": 0.20129864,
        },
    )
)
KNOCKS = types.SimpleNamespace(
    x=np.array([0.5549895, 1.111674, 1.1153355, 1.64751]),
    y=np.array([0.5422165, 0.559208, 0.8657980, 0.3023465]),
    pretension=np.full(4, 350.0),
    frequency=np.array([3.1451665, 3.1434531, 3.9619628, 3.6363721]),
    frequency_sigma=np.array([0.00076, 0.00064, 0.00524, 0.00852]),
    damping_ratio=np.array([0.00028, 0.0, 0.00398, 0.00683]),
)


@pytest.fixture(scope="module")
def tuning():
    return tune(types.SimpleNamespace(robot=RIG_A, of_setting=lambda label: RIG_A), KNOCKS)


@pytest.mark.slow
def test_two_fifths_of_the_vibration_are_predicted_to_be_left_at_most(tuning):
    assert tuning.legs.share <= 0.4
    assert tuning.legs.worst_share <= 0.6


@pytest.mark.slow
def test_no_region_is_predicted_to_be_worse_than_plain(tuning):
    assert all(regional.share <= 1 for regional in tuning.shapers)


@pytest.mark.slow
def test_the_robot_rests_no_further_from_its_targets(tuning):
    legs = tuning.legs
    assert legs.after.resting_error.mean() <= 1.05 * legs.before.resting_error.mean()


@pytest.mark.slow
def test_shapers_have_few_impulses(tuning):
    assert all(regional.shaper.times.size <= 4 for regional in tuning.shapers)


@pytest.mark.slow
def test_what_is_worth_it_is_told(tuning):
    assert any("random legs" in note for note in tuning.notes)


@pytest.mark.slow
@leg_rigs.needs_compiler
@pytest.mark.parametrize("seed", [201, 202])
def test_a_rig_of_another_program_does_what_is_predicted(seed):
    rig = leg_rigs.draw_rig(seed, elastic=False)
    tuning = tune(_fit_of(rig), None, effort=Effort(planned=0))
    legs = leg_rigs.random_legs(seed, 30)
    plain, now = (
        np.array([driven(rig, leg, tuning if tuned else None) for leg in legs]).T
        for tuned in (False, True)
    )
    left = share(now[0], plain[0])
    assert left <= 0.4
    assert 1 / 1.5 <= tuning.legs.share / left <= 1.5
    assert worse(now[0], plain[0]) <= 0.05
    assert np.mean(now[1]) <= 1.1 * np.mean(plain[1])


def _fit_of(rig):
    robot = exact(
        replace(
            consistent(),
            {
                "effective_pretension": rig.pretension,
                "friction_coefficient": rig.lower_friction,
                "drive_inertia": rig.inertia,
                "drive_damping": rig.damping,
            },
        )
    )
    return types.SimpleNamespace(robot=robot, of_setting=lambda label: robot)


def driven(rig, leg, tuning):
    """Vibration and resting error of a leg on a rig, plain or tuned [m]."""
    if tuning is None:
        shaper, controller = Shaper(np.zeros(1), np.ones(1)), published_pd()
    else:
        setting = tuning.robots[0].pretension
        shaper, controller = tuning.shaper_at(*leg.end, setting).shaper, tuning.controller
    arrival = leg.time + float(shaper.duration)
    run = leg_rigs.drive_leg(
        rig,
        leg_rigs.start_of(rig, leg),
        leg_rigs.pulleys(leg_rigs.shaped_profile(leg, shaper.times, shaper.amplitudes)),
        gains=(float(controller.proportional_gain), float(controller.derivative_gain)),
        duration=arrival + leg_rigs.HOLD,
    )
    return run.vibration(arrival), run.resting_error(leg.end)


@pytest.mark.slow
def test_the_flexible_robot_keeps_its_margins_everywhere(tuning):
    worst = {one.measure: one.value for one in tuning.worst_margins}
    assert worst["phase_margin"] >= PHASE_MARGIN
    assert worst["peak_sensitivity"] <= PEAK_SENSITIVITY


@pytest.mark.slow
def test_the_commands_stay_within_the_drives(tuning):
    assert tuning.predicted[0].after.largest_voltage <= float(RIG_A.drive.voltage_limit)


@pytest.mark.slow
def test_gains_that_make_a_region_worse_are_given_up_for_those_of_eq_25(monkeypatch):
    monkeypatch.setattr("tuning.gains.tune._is_no_worse", lambda shapers, legs: False)
    given_up = tune(
        types.SimpleNamespace(robot=RIG_A, of_setting=lambda label: RIG_A),
        KNOCKS,
        effort=Effort(legs=4, population=4, generations=1, planned=0),
    )
    assert float(given_up.controller.proportional_gain) == float(PLAIN.proportional_gain)
    assert all(regional.share <= 1 for regional in given_up.shapers)


def test_nothing_is_tuned_for_a_robot_whose_fit_has_failed():
    failed = types.SimpleNamespace(robot=RIG_A, of_setting=lambda label: RIG_A, fits=False)
    with pytest.raises(ValueError, match="model_does_not_fit"):
        tune(failed, KNOCKS)
