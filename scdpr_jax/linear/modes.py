r"""Natural frequencies and mode shapes of an aligned pose, from Eqs. (18)-(20).

What holds the carriages decides the frequencies more than anything else, and the paper
doesn't say it: a `Condition` is part of every question. The height $y_e$ doesn't couple
into an aligned pose and has no stiffness, so that four coordinates remain,
$[x_e, \delta_e, q_3, q_4]$. Damping is left out; with it, see `scdpr_jax.linear.model`.
"""

import enum

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.linear.model import mass_matrix, stiffness_matrix
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, TILT, UPPER, X


class Lower(enum.Enum):
    """What the lower carriage does while the robot vibrates."""

    FREE = "free of the drives"
    DRIVEN = "carrying the drives' inertia"
    HELD = "held"


class Upper(enum.Enum):
    """What the upper carriage does while the robot vibrates."""

    FREE = "free"
    HELD = "held"


class Condition(eqx.Module):
    """What holds the two carriages while the robot vibrates."""

    lower: Lower = eqx.field(static=True)
    """The lower carriage; as Eq. (18) prints it, it is free of the drives."""
    upper: Upper = eqx.field(static=True)
    """The upper carriage."""

    @property
    def moving(self) -> tuple[int, ...]:
        r"""Which of $[x_e, \delta_e, q_3, q_4]$ move."""
        lower = () if self.lower is Lower.HELD else (LOWER,)
        upper = () if self.upper is Upper.HELD else (UPPER,)
        return (X, TILT, *lower, *upper)

    @property
    def slides(self) -> bool:
        """Whether the whole robot can slide along the frame, at no frequency."""
        return len(self.moving) == 4

    @property
    def modes(self) -> int:
        """How many elastic modes there are; sliding along the frame isn't one."""
        return len(self.moving) - self.slides


PRINTED = Condition(Lower.FREE, Upper.FREE)
"""As Eq. (18) prints it: both carriages free, no drive."""
DRIVEN = Condition(Lower.DRIVEN, Upper.FREE)
"""Both carriages free, the lower one carrying the drives' reflected inertia."""
LOWER_HELD = Condition(Lower.HELD, Upper.FREE)
"""The lower carriage held, as by stiff position control; the upper one free."""
BOTH_HELD = Condition(Lower.HELD, Upper.HELD)
"""Both carriages held by friction."""

CONDITIONS: tuple[Condition, ...] = tuple(
    Condition(lower, upper) for upper in Upper for lower in Lower
)
"""Every condition of the two carriages."""


class Modes(eqx.Module):
    """The elastic modes of a pose, from the lowest frequency up."""

    frequency: Float[Array, "... modes"] = eqx.field(converter=real, metadata=si("Hz", "f_n"))
    """Natural frequencies $f_n$ [Hz]."""
    shape: Float[Array, "... modes 4"] = eqx.field(
        converter=real, metadata=si("m, rad", r"\phi")
    )
    r"""Mode shapes $\phi_n$ in $[x_e, \delta_e, q_3, q_4]$, one a row
    [$1/\sqrt{\mathrm{kg}}$, for the rotation $1/\sqrt{\mathrm{kg\,m^2}}$]:
    $\phi_n^T M \phi_n = 1$, their largest component positive, a held carriage's zero."""


@jax.jit
def natural_frequencies(
    robot: Robot, height: Float[Array, ""], condition: Condition
) -> Float[Array, " modes"]:
    r"""Natural frequencies of the elastic modes, $K \phi = (2\pi f)^2 M \phi$, Eq. (18).

    Where both carriages move, the robot can also slide as a whole, at 0 Hz. That motion is
    known and taken out beforehand, so that what is left is positive and differentiable
    where no two frequencies meet.

    Args:
        robot: The robot; its friction has no part in it.
        height: Height $y_e$ of the end-effector [m].
        condition: What holds the carriages.

    Returns:
        Frequencies [Hz], ascending, `condition.modes` of them.
    """
    elastic, _ = _elastic_problem(robot, height, condition)
    return jnp.sqrt(jnp.linalg.eigvalsh(elastic)) / (2 * jnp.pi)


@jax.jit
def held_frequency(robot: Robot, height: Float[Array, ""]) -> Float[Array, ""]:
    """Natural frequency of the sway while friction holds both carriages.

    Args:
        robot: The robot; its friction has no part in it.
        height: Height $y_e$ of the end-effector [m].

    Returns:
        The lowest frequency of `BOTH_HELD` [Hz].
    """
    return natural_frequencies(robot, height, BOTH_HELD)[0]


@jax.jit
def modes(robot: Robot, height: Float[Array, ""], condition: Condition) -> Modes:
    r"""Natural frequencies and mode shapes of the elastic modes, Eq. (18).

    Args:
        robot: The robot; its friction has no part in it.
        height: Height $y_e$ of the end-effector [m].
        condition: What holds the carriages.

    Returns:
        The modes.
    """
    elastic, basis = _elastic_problem(robot, height, condition)
    squares, vectors = jnp.linalg.eigh(elastic)
    shapes = vectors.T @ basis
    largest = jnp.argmax(jnp.abs(shapes), axis=1, keepdims=True)
    sign = jnp.sign(jnp.take_along_axis(shapes, largest, axis=1))
    return Modes(frequency=jnp.sqrt(squares) / (2 * jnp.pi), shape=sign * shapes)


def _elastic_problem(
    robot: Robot, height: Float[Array, ""], condition: Condition
) -> tuple[Float[Array, "modes modes"], Float[Array, "modes 4"]]:
    """The mass-normalised stiffness of the elastic motions, and their basis.

    The basis is mass-orthonormal, one motion a row; it leaves out sliding as a whole.
    """
    mass = jnp.diagonal(mass_matrix(robot))
    if condition.lower is Lower.DRIVEN:
        mass = masses(robot)[:HEIGHT]
    root = jnp.sqrt(mass)
    motions = jnp.eye(4, dtype=root.dtype)[jnp.asarray(condition.moving)]
    if condition.slides:
        motions = _complement(root * jnp.asarray([1, 0, 1, 1], dtype=root.dtype))
    basis = motions / root[None, :]
    return basis @ stiffness_matrix(robot, height) @ basis.T, basis


def _complement(vector: Float[Array, " n"]) -> Float[Array, "n-1 n"]:
    r"""An orthonormal basis of what is orthogonal to a vector whose first entry is positive.

    The rows after the first of the Householder reflection that turns the vector to the
    first axis; smooth, as its normal $u/|u| + e_1$ never vanishes.
    """
    unit = vector / jnp.linalg.norm(vector)
    normal = unit.at[0].add(1)
    reflection = jnp.eye(unit.size, dtype=unit.dtype) - jnp.outer(normal, normal) / normal[0]
    return reflection[1:]
