r"""The cable loop: lengths, potential, angles and tensions, Eqs. (4)-(8), (14), (17).

The loop has constant tension, so that its moving parts pull with the potential
$V(q) = 2T(\ell_\alpha + \ell_\beta + \ell_\gamma)$: two parallel cables on each of the
three paths. Everything else follows from the three path vectors.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, TILT


class Path(NamedTuple):
    """A straight path of the loop, from its lower to its upper end."""

    horizontal: Float[Array, ""]
    """Lower end's horizontal position minus the upper end's [m]."""
    vertical: Float[Array, ""]
    """Height of the upper end over the lower end [m]."""

    @property
    def length(self) -> Float[Array, ""]:
        """Length of the path [m]."""
        return jnp.sqrt(jnp.square(self.horizontal) + jnp.square(self.vertical))

    @property
    def direction(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Sine and cosine of the angle to the vertical [1]."""
        return self.horizontal / self.length, self.vertical / self.length

    @property
    def angle(self) -> Float[Array, ""]:
        """Angle to the vertical [rad], Eq. (4)."""
        return jnp.arctan2(self.horizontal, self.vertical)


class Paths(NamedTuple):
    """The three paths of the loop between the guides."""

    alpha: Path
    """Lower inner path: lower carriage to the end-effector's lower attachment."""
    beta: Path
    """Upper inner path: end-effector's upper attachment to the upper carriage."""
    gamma: Path
    """Outer path: lower carriage to upper carriage."""


def paths(robot: Robot, position: Float[Array, "5"]) -> Paths:
    r"""Paths of the loop, the fractions of Eq. (4).

    $$ \alpha: (q_3 - q_1 - a\sin q_2,\; y - a\cos q_2), \quad
       \beta: (q_1 - q_4 - b\sin q_2,\; H - y - b\cos q_2), \quad
       \gamma: (q_3 - q_4,\; H) $$

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        The three paths.
    """
    x, tilt, lower, upper, y = jnp.unstack(position)
    a, b = robot.end_effector.lower_offset, robot.end_effector.upper_offset
    height = robot.frame.height
    sine, cosine = _direction(tilt)
    return Paths(
        alpha=Path(lower - x - a * sine, y - a * cosine),
        beta=Path(x - upper - b * sine, height - y - b * cosine),
        gamma=Path(lower - upper, height),
    )


def _direction(angle: Float[Array, ""]) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Sine and cosine of an angle, which are dear enough to be computed once only."""
    return jnp.sin(angle), jnp.cos(angle)


def potential(robot: Robot, position: Float[Array, "5"]) -> Float[Array, ""]:
    r"""Potential of the loop and of gravity [J], whose gradient Eqs. (7), (8), (16) are.

    $$ V = 2T(\ell_\alpha + \ell_\beta + \ell_\gamma) + k \lambda^2 / 2 + m_e g y_e $$

    with the loop's lengthening $\lambda$ and its stiffness $k$, zero by default.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Potential energy [J].
    """
    alpha, beta, gamma = paths(robot, position)
    loop = 2 * robot.cable.effective_pretension * (alpha.length + beta.length + gamma.length)
    spring = robot.cable.stiffness * jnp.square(lengthening(robot, position)) / 2
    return loop + spring + robot.end_effector.mass * robot.gravity * position[HEIGHT]


def lengthening(robot: Robot, position: Float[Array, "5"]) -> Float[Array, ""]:
    r"""How much longer the loop's path is than with everything aligned.

    $$ \lambda = 2(\ell_\alpha + \ell_\beta + \ell_\gamma) - 2(2H - a - b) $$

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        The lengthening [m].
    """
    body = robot.end_effector
    aligned = 2 * robot.frame.height - body.lower_offset - body.upper_offset
    return 2 * (sum(path.length for path in paths(robot, position)) - aligned)


def cable_angles(robot: Robot, position: Float[Array, "5"]) -> Float[Array, "3"]:
    r"""Angles $[\alpha, \beta, \gamma]$ of the paths to the vertical, Eq. (4).

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Angles [rad].
    """
    return jnp.stack([path.angle for path in paths(robot, position)])


def small_cable_angles(robot: Robot, position: Float[Array, "5"]) -> Float[Array, "3"]:
    r"""Angles $[\alpha, \beta, \gamma]$ for small inclinations, Eq. (17).

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Angles [rad].
    """
    return jnp.stack([path.horizontal / path.vertical for path in paths(robot, position)])


class LoopForces(NamedTuple):
    """What the loop does to the robot at a position."""

    pull: Float[Array, "5"]
    """Forces on the coordinates [N, N m, N, N, N]: minus the gradient of the potential."""
    normal: Float[Array, "2"]
    """Forces on the guides of the lower and the upper carriage [N]."""


def loop_forces(robot: Robot, position: Float[Array, "5"]) -> LoopForces:
    r"""Forces of the loop, Eqs. (7), (8), (16), and the vertical one that is not printed.

    $$ \begin{aligned}
       Q_1 &= 2T(\sin\alpha - \sin\beta) &
       Q_2 &= 2T(a\sin(\alpha - q_2) + b\sin(\beta - q_2)) \\
       Q_3 &= -2T(\sin\gamma + \sin\alpha) &
       Q_4 &= 2T(\sin\gamma + \sin\beta) \\
       Q_y &= -2T(\cos\alpha - \cos\beta) &
       N_3 &= 2T(\cos\gamma + \cos\alpha), \quad N_4 = 2T(\cos\gamma + \cos\beta)
       \end{aligned} $$

    with $T + k\lambda$ in place of $T$ where the loop has a stiffness.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Pull on the coordinates and normal forces of the guides.
    """
    (sin_a, cos_a), (sin_b, cos_b), (sin_g, cos_g) = (
        path.direction for path in paths(robot, position)
    )
    a, b = robot.end_effector.lower_offset, robot.end_effector.upper_offset
    tilt = jnp.unstack(position)[TILT]
    sine, cosine = _direction(tilt)
    lower_arm = a * (sin_a * cosine - cos_a * sine)
    upper_arm = b * (sin_b * cosine - cos_b * sine)
    pull = (sin_a - sin_b, lower_arm + upper_arm, -sin_g - sin_a, sin_g + sin_b, cos_b - cos_a)
    normal = (cos_g + cos_a, cos_g + cos_b)
    cable = robot.cable
    tension = 2 * (cable.effective_pretension + cable.stiffness * lengthening(robot, position))
    return LoopForces(
        jnp.stack([tension * share for share in pull]),
        jnp.stack([tension * share for share in normal]),
    )


def carriage_stiffness(robot: Robot, position: Float[Array, "5"]) -> Float[Array, "2 5"]:
    r"""How the loop resists the carriages: their rows of the potential's Hessian.

    At the pretension: the loop's own stiffness, whose part is of second order in the
    inclinations, is left out.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Force against each coordinate per displacement of the lower and of the upper
        carriage [N/m; N for the rotation].
    """
    alpha, beta, gamma = paths(robot, position)
    (sin_a, cos_a), (sin_b, cos_b), (_, cos_g) = (p.direction for p in (alpha, beta, gamma))
    a, b = robot.end_effector.lower_offset, robot.end_effector.upper_offset
    tilt = jnp.unstack(position)[TILT]
    sine, cosine = _direction(tilt)
    k_a, k_b, k_g = cos_a / alpha.length, cos_b / beta.length, jnp.square(cos_g) / gamma.length
    lower = [
        -k_a * cos_a,
        -k_a * a * (cos_a * cosine + sin_a * sine),
        k_a * cos_a + k_g,
        -k_g,
        -k_a * sin_a,
    ]
    upper = [
        -k_b * cos_b,
        k_b * b * (cos_b * cosine + sin_b * sine),
        -k_g,
        k_b * cos_b + k_g,
        -k_b * sin_b,
    ]
    tension = 2 * robot.cable.effective_pretension
    return jnp.stack([jnp.stack([tension * k for k in row]) for row in (lower, upper)])


def tension_increase(robot: Robot, torque: Float[Array, "2"]) -> Float[Array, ""]:
    r"""Rise of the loop's tension between the drives and the lower carriage, Eq. (6).

    $$ \Delta T = (\tau_1 + \tau_2) / (2r) $$

    Args:
        robot: The robot.
        torque: Torques of the two driver pulleys [N m].

    Returns:
        Rise of the tension [N].
    """
    return (torque[0] + torque[1]) / (2 * robot.drive.effective_radius)
