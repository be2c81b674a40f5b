"""One leg, planned for rig-a, and run under control on robots that differ from it."""

import equinox as eqx
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import single
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.plan.planning import plan_leg

NUMBERS = {
    "effective_pretension": 85.166460,
    "friction_coefficient": 0.018270845,
    "drive_inertia": 0.014530930,
    "drive_damping": 0.20129864,
}
FITTED = exact(replace(consistent(), NUMBERS))
START, END = (0.3, 0.55), (1.9, 0.55)


@pytest.fixture(scope="module")
def leg():
    return plan_leg(FITTED, published_pd(), START, END)


@eqx.filter_jit
def run(robot, commands):
    return run_leg(robot, single(robot, commands.commanded[0]).start, commands)


def planned(robot, leg):
    return run(robot, leg.commands(robot, published_pd(), rest=1.0))


def plain(robot, leg):
    law = CommandLaw(rest_to_rest(START, END, duration=leg.time[-1]), published_pd())
    return run(robot, law.commands(leg.time.size + 1000))


@pytest.mark.slow
@pytest.mark.parametrize(("tension", "left"), [(1.0, 0.1), (1.02, 0.25), (0.98, 0.25)])
def test_the_vibration_of_the_plain_leg_is_cut(leg, tension, left):
    share = {**NUMBERS, "effective_pretension": 85.166460 * tension}
    robot = exact(replace(consistent(), share))
    after, before = planned(robot, leg).measures, plain(robot, leg).measures
    assert after.residual_vibration <= left * before.residual_vibration


@pytest.mark.slow
def test_it_rests_at_the_target(leg):
    # Half of what the plain leg leaves, 1.5 mm.
    assert planned(FITTED, leg).measures.resting_error < 0.75e-3


@pytest.mark.slow
def test_the_drives_are_led_from_the_start_to_the_target(leg):
    np.testing.assert_allclose(leg.driven(FITTED)[[0, -1]], [START, END], atol=1e-12)


@pytest.mark.slow
def test_the_commands_stay_within_the_drives(leg):
    assert planned(FITTED, leg).measures.largest_voltage < 10.0
