import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import Variation, single, varied
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent

ROBOT = exact(consistent())
PLACE = jnp.asarray([1.0, 0.5])
LAW = CommandLaw(rest_to_rest(PLACE, PLACE + 0.1, duration=0.3), published_pd())


@pytest.fixture(scope="module")
def leg():
    return eqx.filter_jit(run_leg)(ROBOT, single(ROBOT, PLACE).start, LAW.commands(600))


def test_a_leg_is_the_simulators_closed_loop(leg):
    reference = LAW.commands(600).commanded
    run = eqx.filter_jit(closed_loop)(
        ROBOT, single(ROBOT, PLACE).start, published_pd(), reference=reference
    )
    np.testing.assert_allclose(leg.states.position, run.states.position, atol=1e-12)
    np.testing.assert_allclose(leg.voltage, run.voltage, atol=1e-9)


def test_the_measures_are_of_the_traces(leg):
    error = np.hypot(*(np.asarray(leg.pose) - np.asarray(leg.commanded)).T)
    assert float(leg.measures.largest_error) == pytest.approx(error.max(), rel=1e-12)
    swing = np.ptp(np.asarray(leg.pose)[300:, 0])
    assert float(leg.measures.residual_vibration) == pytest.approx(swing, rel=1e-12)


def test_a_shorter_leg_is_its_first_samples(leg):
    short = leg.until(400)
    assert short.time.shape == (400,)
    assert short.voltage.shape == (399, 2)
    np.testing.assert_array_equal(short.pose, np.asarray(leg.pose)[:400])
    assert float(short.measures.largest_error) == float(leg.measures.largest_error)


def test_legs_of_an_ensemble_are_each_robots_own(leg):
    robots = varied(ROBOT, (Variation(), Variation(tension=1.1)), PLACE)
    commands = LAW.commands(600)
    legs = jax.jit(jax.vmap(lambda each: run_leg(each.robot, each.start, commands)))(robots)
    # The batch sums in another order.
    np.testing.assert_allclose(legs.pose[0], leg.pose, atol=1e-9)
    assert float(jnp.max(jnp.abs(legs.pose[1] - leg.pose))) > 1e-5
