r"""The nonlinear equations of motion: minus the gradient of the potential, drives, friction.

The driver pulleys follow the lower carriage and the height (`scdpr_jax.robot.state`), so that
the drives' inertia and damping belong to $q_3$ and $y_e$. In these coordinates the mass matrix
is diagonal and constant: accelerations are a division, where coordinates of the motors would
need a solve in every stage of every step.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.cable import LoopForces, loop_forces, potential
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State, driven


def masses(robot: Robot) -> Float[Array, "5"]:
    r"""Diagonal of the mass matrix, Eq. (19) with the drives' reflected inertia.

    $$ [m_e,\; I_e,\; m_3 + 2J/r^2,\; m_4,\; m_e + 2J/r^2] $$

    Args:
        robot: The robot.

    Returns:
        Masses of the coordinates [kg, kg m², kg, kg, kg].
    """
    body, drive = robot.end_effector, robot.drive
    reflected = 2 * drive.inertia / jnp.square(drive.effective_radius)
    return jnp.stack(
        [
            body.mass,
            body.inertia,
            robot.lower_carriage.mass + reflected,
            robot.upper_carriage.mass,
            body.mass + reflected,
        ]
    )


def dampings(robot: Robot) -> Float[Array, "5"]:
    r"""Diagonal of the viscous damping matrix.

    $$ [0,\; 0,\; 2b/r^2 + d_3,\; d_4,\; 2b/r^2] $$

    Args:
        robot: The robot.

    Returns:
        Dampings of the coordinates [N s/m, N m s, N s/m, N s/m, N s/m].
    """
    reflected = 2 * robot.drive.damping / jnp.square(robot.drive.effective_radius)
    zero = jnp.zeros_like(reflected)
    lower, upper = robot.lower_carriage.friction, robot.upper_carriage.friction
    return jnp.stack([zero, zero, reflected + lower.viscous, upper.viscous, reflected])


def drive_forces(robot: Robot, torque: Float[Array, "2"]) -> Float[Array, "5"]:
    r"""Generalised forces of the drives' torques.

    $$ [0,\; 0,\; (\tau_1 + \tau_2)/r,\; 0,\; (\tau_1 - \tau_2)/r] $$

    Args:
        robot: The robot.
        torque: Torques of the driver pulleys [N m].

    Returns:
        Forces on the coordinates [N, N m, N, N, N].
    """
    zero = jnp.zeros_like(torque[0])
    force = torque / robot.drive.effective_radius
    return jnp.stack([zero, zero, force[0] + force[1], zero, force[0] - force[1]])


def pulley_rates(robot: Robot, velocity: Float[Array, "5"]) -> Float[Array, "2"]:
    r"""Angular velocities of the driver pulleys, the derivative of Eq. (3).

    Args:
        robot: The robot.
        velocity: Velocities of the coordinates [m/s, rad/s, m/s, m/s, m/s].

    Returns:
        $[\dot\alpha_1, \dot\alpha_2]$ [rad/s].
    """
    lower, height = driven(velocity)
    return jnp.stack([lower + height, lower - height]) / robot.drive.effective_radius


def smooth_forces(
    robot: Robot,
    loop: LoopForces,
    velocity: Float[Array, "5"],
    *,
    torque: Float[Array, "2"],
    knock: Float[Array, ""],
) -> Float[Array, "5"]:
    """Every force but dry friction: Eqs. (7), (8), (16) without it.

    Args:
        robot: The robot.
        loop: Forces of the loop at its position.
        velocity: Velocities of the coordinates [m/s, rad/s, m/s, m/s, m/s].
        torque: Torques of the driver pulleys [N m].
        knock: Horizontal force on the end-effector [N].

    Returns:
        Forces on the coordinates [N, N m, N, N, N].
    """
    driven = drive_forces(robot, torque)
    outer = gravity_force(robot) + knock_forces(robot, knock)
    parts = (loop.pull, outer, driven, dampings(robot), velocity)
    return jnp.stack(
        [
            pull + outer + drive - damping * speed
            for pull, outer, drive, damping, speed in zip(*map(jnp.unstack, parts), strict=True)
        ]
    )


def knock_forces(robot: Robot, knock: Float[Array, ""]) -> Float[Array, "5"]:
    r"""Generalised forces of a horizontal knock on the end-effector, $[F, -hF, 0, 0, 0]$.

    Args:
        robot: The robot, with the height $h$ at which it is knocked.
        knock: Horizontal force $F$ on the end-effector [N].

    Returns:
        Forces on the coordinates [N, N m, N, N, N].
    """
    zero = jnp.zeros_like(knock)
    return jnp.stack([knock, -robot.end_effector.knock_arm * knock, zero, zero, zero])


def gravity_force(robot: Robot) -> Float[Array, "5"]:
    """Weight of the end-effector on the coordinates; zero by default, as in the paper.

    Args:
        robot: The robot.

    Returns:
        Forces on the coordinates [N, N m, N, N, N].
    """
    weight = robot.end_effector.mass * robot.gravity
    return jnp.zeros(5, dtype=weight.dtype).at[HEIGHT].set(-weight)


def drive_friction(robot: Robot, velocity: Float[Array, "5"]) -> Float[Array, "2"]:
    r"""Smoothed dry friction of the drives, $\tau_f \tanh(\dot\alpha / \omega_s)$.

    Args:
        robot: The robot.
        velocity: Velocities of the coordinates [m/s, rad/s, m/s, m/s, m/s].

    Returns:
        Friction torques of the two drives [N m], along their rates.
    """
    drive = robot.drive
    return drive.frictions * jnp.tanh(pulley_rates(robot, velocity) / drive.friction_width)


def friction_forces(
    robot: Robot, loop: LoopForces, velocity: Float[Array, "5"]
) -> Float[Array, "2"]:
    """Dry friction of the two carriages by their laws, Eq. (21).

    The viscous part of a law is in `dampings`.

    Args:
        robot: The robot.
        loop: Forces of the loop at its position.
        velocity: Velocities of the coordinates [m/s, rad/s, m/s, m/s, m/s].

    Returns:
        Friction forces of the lower and the upper carriage [N], along their velocities.
    """
    lower, upper = robot.lower_carriage.friction, robot.upper_carriage.friction
    return jnp.stack(
        [
            lower.dry(velocity[LOWER], loop.normal[0]),
            upper.dry(velocity[UPPER], loop.normal[1]),
        ]
    )


def accelerations(
    robot: Robot,
    state: State,
    *,
    torque: Float[Array, "2"],
    knock: Float[Array, ""],
) -> Float[Array, "5"]:
    r"""The equations of motion, Eqs. (7), (8), (10) with (16), and the height's.

    $$ M \ddot q = -\nabla V(q) - D \dot q + B\tau - F_{friction}(q, \dot q) $$

    Args:
        robot: The robot; its friction laws should be smooth.
        state: Its state.
        torque: Torques of the motors at the output shafts [N m].
        knock: Horizontal force on the end-effector [N].

    Returns:
        Accelerations of the coordinates [m/s², rad/s², m/s², m/s², m/s²].
    """
    loop = loop_forces(robot, state.position)
    driven = torque - drive_friction(robot, state.velocity)
    smooth = smooth_forces(robot, loop, state.velocity, torque=driven, knock=knock)
    dry = friction_forces(robot, loop, state.velocity)
    return smooth.at[LOWER:HEIGHT].add(-dry) / masses(robot)


def energy(robot: Robot, state: State) -> Float[Array, ""]:
    r"""Mechanical energy, $\tfrac12 \dot q^T M \dot q + V(q)$ [J], Eq. (9) and the loop's.

    Args:
        robot: The robot.
        state: Its state.

    Returns:
        Kinetic and potential energy [J].
    """
    kinetic = jnp.sum(masses(robot) * jnp.square(state.velocity)) / 2
    return kinetic + potential(robot, state.position)
