r"""Dynamics inversion: the voltages that a motion of lower carriage and height asks for.

The drives act on $q_3$ and $y_e$ alone; end-effector, rotation and upper carriage follow
through the loop. So what is inverted are these two rows of the equations of motion, with
the loop's pull as it is at the moment.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.engines.stepping import friction_coefficients
from scdpr_jax.robot.cable import loop_forces
from scdpr_jax.robot.dynamics import dampings, drive_friction, gravity_force, masses
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, State, driven

TURN_ROUND = 2e-3
"""Velocity over which the compensated friction turns round [m/s]: a step of the commands
where a reference stops would shake what it is to hold."""


class Motion(eqx.Module):
    """A commanded motion of the lower carriage and of the height, $[q_3, y_e]$."""

    position: Float[Array, "... 2"] = eqx.field(metadata=si("m"))
    """Positions [m]."""
    velocity: Float[Array, "... 2"] = eqx.field(metadata=si("m/s"))
    """Velocities [m/s]."""
    acceleration: Float[Array, "... 2"] = eqx.field(metadata=si("m/s^2"))
    """Accelerations [m/s²]."""


def inverse_dynamics(robot: Robot, state: State, motion: Motion) -> Float[Array, "2"]:
    r"""Commands under which lower carriage and height accelerate as motion.

    $$ f = m \ddot q + d \dot q + \mu N \tanh(\dot q / v_s) + \partial V / \partial q,
       \qquad \tau = \tfrac{r}{2} [f_3 + f_y,\; f_3 - f_y] $$

    with the friction of the lower carriage only, and each drive's own added to its $\tau$.

    Args:
        robot: The robot.
        state: Its state, of which the loop's pull is taken.
        motion: The motion at that moment; its velocity decides which way friction acts.

    Returns:
        Commands of both drives, not saturated [V].
    """
    loop, drive = loop_forces(robot, state.position), robot.drive
    pull = driven(loop.pull + gravity_force(robot))
    inertial = driven(masses(robot)) * motion.acceleration
    viscous = driven(dampings(robot)) * motion.velocity
    limit = friction_coefficients(robot)[0] * loop.normal[0]
    dry = limit * jnp.tanh(motion.velocity[0] / TURN_ROUND)
    force = (inertial + viscous - pull).at[0].add(dry)
    torque = drive.effective_radius / 2 * jnp.stack([force[0] + force[1], force[0] - force[1]])
    moving = jnp.zeros(5, dtype=force.dtype).at[LOWER :: HEIGHT - LOWER].set(motion.velocity)
    return (torque + drive_friction(robot, moving)) / drive.torque_per_volt
