r"""The linear models: the paper's, Eqs. (18)-(21), and the state space at a pose.

The paper's model $M \ddot q + K q = w$ has the four coordinates
$q = [x_e, \delta_e, q_3, q_4]$ of an aligned pose, no drive and no height. `linearise`
has all five coordinates, the drives and any pose.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.cable import potential
from scdpr_jax.robot.dynamics import dampings, drive_forces, knock_forces, masses
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import LOWER, UPPER


def mass_matrix(robot: Robot) -> Float[Array, "4 4"]:
    r"""Mass matrix $M = \mathrm{diag}(m_e, I_e, m_3, m_4)$, Eq. (19).

    As printed, without the drives; `scdpr_jax.robot.dynamics.masses` has their inertia.

    Args:
        robot: The robot.

    Returns:
        Masses of $[x_e, \delta_e, q_3, q_4]$ [kg, kg m², kg, kg].
    """
    body = robot.end_effector
    return jnp.diag(
        jnp.stack(
            [body.mass, body.inertia, robot.lower_carriage.mass, robot.upper_carriage.mass]
        )
    )


def stiffness_matrix(robot: Robot, height: Float[Array, ""]) -> Float[Array, "4 4"]:
    r"""Stiffness matrix $K$ of an aligned pose, Eq. (20).

    $$ z_1 = H - y_e - b, \qquad z_2 = y_e - a $$

    $K_{21}$ is printed as $2T(1/z_2 - 1/z_1)$, which has the wrong dimension and leaves $K$
    asymmetric; Eq. (16) gives $K_{12}$ for it: see `docs/errata.md`.

    Args:
        robot: The robot.
        height: Height $y_e$ of the end-effector [m].

    Returns:
        Force against each coordinate per displacement of $[x_e, \delta_e, q_3, q_4]$ [N/m;
        N and N m for the rotation].
    """
    a, b = robot.end_effector.lower_offset, robot.end_effector.upper_offset
    H = robot.frame.height
    z_1, z_2 = H - height - b, height - a
    matrix = [
        [1 / z_2 + 1 / z_1, a / z_2 - b / z_1, -1 / z_2, -1 / z_1],
        [a / z_2 - b / z_1, a**2 / z_2 + a + b**2 / z_1 + b, -a / z_2, b / z_1],
        [-1 / z_2, -a / z_2, 1 / H + 1 / z_2, -1 / H],
        [-1 / z_1, b / z_1, -1 / H, 1 / H + 1 / z_1],
    ]
    rows = jnp.stack([jnp.stack(row) for row in matrix])
    return 2 * robot.cable.effective_pretension * rows


def external_forces(
    robot: Robot, velocity: Float[Array, "4"], *, torque: Float[Array, "2"]
) -> Float[Array, "4"]:
    r"""External forces $w$ of the paper's linear model, Eq. (21).

    $$ w = \left[0,\; 0,\; \frac{\tau_1 + \tau_2}{r}
       - 4T\mu\,\mathrm{sgn}(\dot q_3),\; -4T\mu\,\mathrm{sgn}(\dot q_4)\right] $$

    The sign function stands for the carriages' friction laws at the aligned pose's normal
    force $4T$; $\dot q_3 / |\dot q_e|$ is a misprint: see `docs/errata.md`.

    Args:
        robot: The robot.
        velocity: Velocities of $[x_e, \delta_e, q_3, q_4]$ [m/s, rad/s, m/s, m/s].
        torque: Torques of the driver pulleys [N m].

    Returns:
        Forces [N, N m, N, N].
    """
    normal = 4 * robot.cable.effective_pretension
    lower = robot.lower_carriage.friction.dry(velocity[LOWER], normal)
    upper = robot.upper_carriage.friction.dry(velocity[UPPER], normal)
    drive = (torque[0] + torque[1]) / robot.drive.effective_radius
    zero = jnp.zeros_like(drive)
    return jnp.stack([zero, zero, drive - lower, -upper])


class StateSpace(eqx.Module):
    r"""The robot near a pose, $\dot x = A x + B u + c$, without dry friction.

    $x = [q - q_0, \dot q]$ has ten rows, $u = [V_1, V_2, F]$ the two commands [V] and the
    knock on the end-effector [N].
    """

    position: Float[Array, "... 5"] = eqx.field(converter=real, metadata=si("m, rad", "q_0"))
    r"""The pose $q_0 = [x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""
    state_matrix: Float[Array, "... 10 10"] = eqx.field(converter=real, metadata=si("SI", "A"))
    """State matrix $A$ [SI units of the rows over those of the columns, per second]."""
    input_matrix: Float[Array, "... 10 3"] = eqx.field(converter=real, metadata=si("SI", "B"))
    """Input matrix $B$ [SI units of the rows per second, over V, V and N]."""
    drift: Float[Array, "... 10"] = eqx.field(converter=real, metadata=si("SI", "c"))
    """What the robot does at the pose itself, at rest: $c$, zero where it is in balance
    [m/s, rad/s and m/s², rad/s²]."""


def stiffness(robot: Robot, position: Float[Array, "5"]) -> Float[Array, "5 5"]:
    r"""Stiffness of the loop at any pose, $\nabla^2 V(q)$.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Force against each coordinate per displacement of each [N/m; N, N m for rotation].
    """
    return jax.hessian(potential, argnums=1)(robot, position)


def linearise(robot: Robot, position: Float[Array, "5"]) -> StateSpace:
    r"""The equations of motion near a pose, at rest and without dry friction.

    $$ A = \begin{pmatrix} 0 & I \\ -M^{-1} \nabla^2 V & -M^{-1} D \end{pmatrix}, \qquad
       B = \begin{pmatrix} 0 \\ M^{-1} [f_1 \; f_2 \; f_F] \end{pmatrix}, \qquad
       c = \begin{pmatrix} 0 \\ -M^{-1} \nabla V \end{pmatrix} $$

    with $f_i$ the forces of one volt on drive $i$ and $f_F$ those of a knock of 1 N. For the
    model without the drives' inertia and damping, as Eq. (18) has it, pass
    `without_drives(robot)`.

    Args:
        robot: The robot; of its friction laws only the viscous part counts.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        The state space.
    """
    mass = masses(robot)
    identity, zeros = jnp.eye(5, dtype=mass.dtype), jnp.zeros((5, 5), dtype=mass.dtype)
    restoring = -stiffness(robot, position) / mass[:, None]
    damping = -jnp.diag(dampings(robot) / mass)

    torques = robot.drive.torque_per_volt * jnp.eye(2, dtype=mass.dtype)
    volts = jax.vmap(drive_forces, in_axes=(None, 0), out_axes=1)(robot, torques)
    newton = knock_forces(robot, jnp.ones_like(mass[0]))[:, None]
    inputs = jnp.concatenate([volts, newton], axis=1) / mass[:, None]
    drift = -jax.grad(potential, argnums=1)(robot, position) / mass
    return StateSpace(
        position=position,
        state_matrix=jnp.block([[zeros, identity], [restoring, damping]]),
        input_matrix=jnp.concatenate([jnp.zeros_like(inputs), inputs]),
        drift=jnp.concatenate([jnp.zeros_like(drift), drift]),
    )


def without_drives(robot: Robot) -> Robot:
    """The robot of Eq. (18): its motors pull, but have neither inertia nor friction.

    Args:
        robot: The robot.

    Returns:
        The robot with drives of no inertia, damping and dry friction.
    """
    zero = jnp.zeros_like(robot.drive.inertia)
    drive = eqx.tree_at(
        lambda d: (d.inertia, d.damping, d.friction, d.friction_difference),
        robot.drive,
        (zero,) * 4,
    )
    return eqx.tree_at(lambda r: r.drive, robot, drive)
