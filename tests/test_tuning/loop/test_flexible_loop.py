"""The flexible robot's joint loops: a plant by its poles is the plant."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.loop.flexible_loop import JOINT_LOOPS, PlantOfPoles, flexible_plant, motions
from tuning.loop.plant import shift_minus_one


@pytest.mark.parametrize("loop", range(len(JOINT_LOOPS)))
@pytest.mark.parametrize(
    "changes",
    [{}, {"effective_pretension": 900.0}, {"drive_damping": 1e-9}, {"drive_inertia": 1e-4}],
)
def test_poles_respond_as_the_plant_does(loop, changes):
    robot = replace(exact(consistent()), {name: jnp.asarray(x) for name, x in changes.items()})
    motion = jax.tree.map(lambda leaf: leaf[loop], motions())
    pd = published_pd()
    plant = flexible_plant(robot, jnp.asarray(0.5), motion, period=pd.period)
    gain = pd.proportional_gain + pd.derivative_gain / pd.period
    poles = PlantOfPoles.of(plant, gain)
    step = jax.vmap(shift_minus_one)(
        jnp.geomspace(0.1, np.pi / float(pd.period), 300) * pd.period
    )
    solved, multiplied = (jax.vmap(own.response)(step) for own in (plant, poles))
    # What the feedback tells of a small response is a difference of nearly equal numbers.
    allowed = 1e-11 * np.abs(solved) + 1e-12 / float(gain)
    assert np.all(np.abs(multiplied - solved) < allowed)
