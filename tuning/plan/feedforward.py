r"""Dynamics inversion: the voltages that a motion of lower carriage and height asks for.

The drives act on $q_3$ and $y_e$ alone; end-effector, rotation and upper carriage follow
through the loop. So what is inverted are these two rows of the equations of motion, with
the loop's pull as it is at the moment.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.engines.stepping import friction_coefficients
from scdpr_jax.robot.cable import loop_forces
from scdpr_jax.robot.dynamics import dampings, drive_friction, gravity_force, masses
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, driven
from tuning.plan.profile import Moment

TURN_ROUND = 2e-3
"""Velocity over which the compensated friction turns round [m/s]: a step of the commands
where a reference stops would shake what it is to hold."""


def inverse_dynamics(
    robot: Robot,
    position: Float[Array, "5"],
    velocity: Float[Array, "2"],
    acceleration: Float[Array, "2"],
) -> Float[Array, "2"]:
    r"""Commands under which lower carriage and height accelerate as motion.

    $$ f = m \ddot q + d \dot q + \mu N \tanh(\dot q / v_s) + \partial V / \partial q,
       \qquad \tau = \tfrac{r}{2} [f_3 + f_y,\; f_3 - f_y] $$

    with the friction of the lower carriage only, and each drive's own added to its $\tau$.

    Args:
        robot: The robot.
        position: Its coordinates, of which the loop's pull is taken [m, rad, m, m, m].
        velocity: Velocities of $[q_3, y_e]$, which decide which way friction acts [m/s].
        acceleration: Their accelerations [m/s²].

    Returns:
        Commands of both drives, not saturated [V].
    """
    loop, drive = loop_forces(robot, position), robot.drive
    pull = driven(loop.pull + gravity_force(robot))
    inertial = driven(masses(robot)) * acceleration
    viscous = driven(dampings(robot)) * velocity
    limit = friction_coefficients(robot)[0] * loop.normal[0]
    dry = limit * jnp.tanh(velocity[0] / TURN_ROUND)
    force = (inertial + viscous - pull).at[0].add(dry)
    torque = drive.effective_radius / 2 * jnp.stack([force[0] + force[1], force[0] - force[1]])
    moving = jnp.zeros(5, dtype=force.dtype).at[LOWER :: HEIGHT - LOWER].set(velocity)
    return (torque + drive_friction(robot, moving)) / drive.torque_per_volt


def stretch(robot: Robot, position: Float[Array, "5"], motion: Moment) -> Float[Array, ""]:
    r"""By how much the cables between drives and lower carriage give, $c\,F$.

    $$ F = m_3 \ddot q_3 + d_3 \dot q_3 + \mu N_3 \tanh(\dot q_3 / v_s)
       + \partial V / \partial q_3 $$

    Args:
        robot: The robot, with the compliance $c$ of its drives.
        position: Its coordinates [m, rad, m, m, m].
        motion: Of lower carriage and height.

    Returns:
        What the drives are to be ahead of the lower carriage [m].
    """
    loop, carriage = loop_forces(robot, position), robot.lower_carriage
    velocity, acceleration = motion.slope[0], motion.curvature[0]
    limit = friction_coefficients(robot)[0] * loop.normal[0]
    dry = limit * jnp.tanh(velocity / TURN_ROUND)
    inertial = carriage.mass * acceleration + carriage.friction.viscous * velocity
    return robot.drive.compliance * (inertial + dry - loop.pull[LOWER])
