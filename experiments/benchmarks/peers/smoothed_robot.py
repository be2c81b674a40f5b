"""The robot with smoothed friction as an ordinary differential equation, for any solver."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from experiments.benchmarks.problem import robot_of, start_of
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import accelerations
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.state import State

WIDTH = 1e-3
"""Velocity over which the smoothed friction turns round [m/s]."""


def slope(
    state: Float[Array, "10"], values: Float[Array, "4"], voltage: Float[Array, "2"]
) -> Float[Array, "10"]:
    """The smoothed robot's equations of motion.

    Args:
        state: Positions and velocities [m, rad; m/s, rad/s].
        values: Values of `experiments.benchmarks.problem.FREE`.
        voltage: Commands [V].

    Returns:
        The state's derivative by time.
    """
    robot = smoothed(robot_of(values), width=WIDTH)
    at = State(state[:5], state[5:])
    torque = motor_torque(robot.drive, voltage)
    force = accelerations(robot, at, torque=torque, knock=jnp.zeros((), state.dtype))
    return jnp.concatenate([at.velocity, force])


@jax.jit
def begin(values: Float[Array, "4"]) -> Float[Array, "10"]:
    """The start of every run.

    Args:
        values: Values of `experiments.benchmarks.problem.FREE`.

    Returns:
        Positions and velocities [m, rad; m/s, rad/s].
    """
    start = start_of(robot_of(values))
    return jnp.concatenate([start.position, start.velocity])
