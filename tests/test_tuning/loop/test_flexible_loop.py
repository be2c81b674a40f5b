"""The flexible robot's joint loops: a plant by its poles is the plant."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.loop.flexible_loop import (
    JOINT_LOOPS,
    PlantsOfPoles,
    controller_response,
    plants,
)
from tuning.loop.responses import pd_gain, sampled_delay, sampled_derivative

PERIOD = 1e-3


@pytest.mark.parametrize(
    "changes",
    [{}, {"effective_pretension": 900.0}, {"drive_damping": 1e-9}, {"drive_inertia": 1e-4}],
)
def test_poles_respond_as_the_plants_do(changes):
    robot = replace(exact(consistent()), changes)
    robots = jax.tree.map(lambda leaf: np.asarray(leaf)[None], robot)
    pd = published_pd()
    own, _ = plants(robots, np.array([0.5]), period=PERIOD)
    gain = float(pd.proportional_gain + pd.derivative_gain / pd.period)
    row = np.repeat(np.arange(len(JOINT_LOOPS)), 300)
    step = np.expm1(1j * np.tile(np.geomspace(0.1 * PERIOD, np.pi, 300), len(JOINT_LOOPS)))
    poles = PlantsOfPoles.of(own, np.full(len(JOINT_LOOPS), gain))
    solved, multiplied = (each.response(row, step) for each in (own, poles))
    # Poles near 1 are right to rounding, of which a slow response sees the share of its step.
    # What the feedback tells of a small one is a difference of nearly equal numbers.
    rounding = 1e-11 + 10 * np.finfo(float).eps / np.abs(step)
    allowed = rounding * np.abs(solved) + 1e-12 / gain
    assert np.all(np.abs(multiplied - solved) < allowed)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_a_controller_responds_as_that_of_a_bare_drives_loop(delay):
    pd = published_pd().from_degrees(0.6, 0.02, filter_time=3e-3)
    omega = np.geomspace(0.1, np.pi / PERIOD, 50)
    stacked = jax.tree.map(lambda leaf: np.asarray(leaf)[None], pd)
    found = controller_response(stacked, np.zeros(50, int), omega, delay=delay)

    @jax.vmap
    def expected(w):
        derivative = sampled_derivative(w, period=pd.period, filter_time=pd.filter_time)
        lag = sampled_delay(w, period=pd.period, delay=delay)
        return lag * pd_gain(pd, derivative)

    np.testing.assert_allclose(found, expected(jnp.asarray(omega)), rtol=1e-13)
