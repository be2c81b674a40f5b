r"""A step of the linear robot between friction's events, tabulated: a matrix exponential."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.engines.stepping import friction_coefficients
from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.dynamics import dampings, masses
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, X, carriages

_PLANE = (0, 1, 2, 3, 5, 6, 7, 8)
"""Rows of the state space that belong to $[x_e, \\delta_e, q_3, q_4]$ and its derivative."""
_TERMS, _DOUBLINGS = 12, 3
"""Taylor terms of the tables, and how often these are doubled: accurate to rounding while a
step takes less than a third of the fastest period."""


class Propagator(eqx.Module):
    r"""A step of the linear robot, tabulated once for a robot, a height and a length."""

    duration: Float[Array, ""] = eqx.field(converter=real, metadata=si("s", "h"))
    """Length of the step [s]."""
    transition: Float[Array, "8 8"] = eqx.field(converter=real, metadata=si("SI", r"\Phi"))
    r"""$e^{hA}$ on $[x_e, \delta_e, q_3, q_4]$ and its derivative [SI, row over column]."""
    responses: Float[Array, "2 8 3"] = eqx.field(converter=real, metadata=si("SI", "G_k"))
    r"""$\varphi_{k+1}(hA)\,b$: answers to an acceleration of 1 m/s a step, constant or grown to
    from zero, of the lower carriage, the upper one and the end-effector [SI, 1 for a speed]."""
    pull: Float[Array, "2 4"] = eqx.field(converter=real, metadata=si("1/s", "-hK/m"))
    """What a displacement of each coordinate does to both carriages in a step [1/s]."""
    coupling: Float[Array, "2 4"] = eqx.field(converter=real, metadata=si("1", "-h^2 K/m"))
    """Acceleration of each coordinate per displacement of both carriages, times the step's
    length squared [1]."""
    mass: Float[Array, "3"] = eqx.field(converter=real, metadata=si("kg", "m"))
    """Masses of both carriages and of the height [kg]."""
    damped: Float[Array, "3"] = eqx.field(converter=real, metadata=si("1", "hd/m"))
    """Share of their speeds that damping takes in a step [1]."""
    limit: Float[Array, "2"] = eqx.field(converter=real, metadata=si("m/s", r"4hT\mu/m"))
    """Largest change of speed of both carriages by their friction in a step [m/s]."""
    height: Float[Array, "2 3"] = eqx.field(converter=real, metadata=si("SI", r"\Phi_y"))
    """The step of height and vertical speed: from the speed, and from an acceleration of 1 m/s
    a step, constant or grown to from zero [SI, 1 for a speed]."""
    drives: Float[Array, "2"] | None = eqx.field(metadata=si("N s", r"h\tau_f/r"))
    """Largest momentum that the dry friction of each drive takes in a step [N s]; `None` where
    it isn't followed."""


@functools.partial(jax.jit, static_argnames="rubbing_drives")
def propagator(
    robot: Robot,
    *,
    height: Float[Array, ""],
    duration: Float[Array, ""],
    rubbing_drives: bool = True,
) -> Propagator:
    """The step of the robot near an aligned pose, tabulated.

    It is one compiled program, as a notebook that doesn't compile would otherwise compile
    hundreds of small ones for it, twenty milliseconds each and in every process.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        height: Height of the end-effector about which the robot is linear [m].
        duration: Length of a step [s], above zero.
        rubbing_drives: Whether the drives' dry friction is followed.

    Returns:
        The tables of `linear_step`.

    Raises:
        TypeError: If a carriage has another friction law.
    """
    aligned = jnp.zeros(5, height.dtype).at[HEIGHT].set(height)
    plane = jnp.array(_PLANE)
    space = linearise(robot, aligned)
    matrix = space.state_matrix[plane][:, plane]
    mass, damping = masses(robot), dampings(robot)
    pushed = jnp.eye(8, dtype=matrix.dtype)[:, 6:]
    knocked = mass[X] * space.input_matrix[plane][:, 2:]
    forced = jnp.concatenate([pushed, knocked], axis=1)
    transition, responses = _exponentials(duration * matrix, forced)
    normal = 4 * robot.cable.effective_pretension
    vertical = jnp.array([[0.0, 1.0], [0.0, 0.0]], matrix.dtype)
    vertical = vertical.at[1, 1].set(-damping[HEIGHT] / mass[HEIGHT])
    moved, (lifted, lifting) = _exponentials(
        duration * vertical, jnp.eye(2, dtype=matrix.dtype)[:, 1:]
    )
    drives = duration * robot.drive.frictions / robot.drive.effective_radius
    return Propagator(
        duration=duration,
        transition=transition,
        responses=responses,
        pull=duration * matrix[6:, :4],
        coupling=jnp.square(duration) * matrix[4:, 2:4].T,
        mass=mass[LOWER:],
        damped=duration * (damping / mass)[LOWER:],
        limit=duration * friction_coefficients(robot) * normal / carriages(mass),
        height=jnp.concatenate([moved[:, 1:], lifted, lifting], axis=1),
        drives=drives if rubbing_drives else None,
    )


def _exponentials(
    matrix: Float[Array, "n n"], forced: Float[Array, "n m"]
) -> tuple[Float[Array, "n n"], Float[Array, "2 n m"]]:
    r"""$e^Z$, and $\varphi_1(Z) B$, $\varphi_2(Z) B$ with $\varphi_k(z) = \sum z^j/(j+k)!$.

    By Taylor's series of $Z/2^d$ and by doubling,

    $$ \varphi_1(2z) = (e^z + 1)\,\varphi_1(z)/2, \qquad
       \varphi_2(2z) = (e^z \varphi_2(z) + \varphi_1(z) + \varphi_2(z))/4 $$

    Without a branch on the norm, so that it is batched and differentiated at its own cost.
    """
    small = matrix / 2**_DOUBLINGS
    identity = jnp.eye(matrix.shape[0], dtype=matrix.dtype)
    whole, second = identity, forced
    for term in range(_TERMS, 0, -1):
        whole = identity + small @ whole / term
        second = forced + small @ second / (term + 2)
    second = second / 2
    first = forced + small @ second
    for _ in range(_DOUBLINGS):
        second = (whole @ second + first + second) / 4
        first = (whole @ first + first) / 2
        whole = whole @ whole
    return whole, jnp.stack([first, second])
