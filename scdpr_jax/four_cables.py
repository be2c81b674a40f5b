r"""The conventional planar robot of four cables, each on its own motor; section 2.1.

The cables run from the corners of the frame to those of an upright end-effector of the same
size and mass as the single loop's. It is what the paper measures its own workspace against.
"""

import itertools

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.parameters import Robot


def needed_tension(
    robot: Robot,
    position: Float[Array, "2"],
    *,
    end_effector_width: Float[Array, ""],
    minimum_tension: Float[Array, ""],
    gravity: Float[Array, ""],
    crossed: bool,
) -> Float[Array, ""]:
    r"""The largest cable tension at a pose when it is as small as can be.

    Tensions that balance the weight are $t = p + \lambda n$, with $n$ spanning the null
    space of the structure matrix. Of all $\lambda$ that keep every cable at the minimum, this
    is the least of the largest tension: a pose lies in the static workspace for every
    $T_{max}$ from here on.

    Args:
        robot: Its frame, and the mass and the offsets of its end-effector, are taken.
        position: Position $[x_e, y_e]$ of the upright end-effector [m].
        end_effector_width: Distance of its left and right attachments [m].
        minimum_tension: Least tension $T_{min}$ of every cable [N].
        gravity: Gravitational acceleration [m/s²].
        crossed: Whether the frame's lower corners hold the upper attachments, and the upper
            corners the lower ones.

    Returns:
        Tension [N]; infinity where the pose can't be held, or lies outside the frame.
    """
    frame, body = robot.frame, robot.end_effector
    directions, torques = _cables(robot, position, end_effector_width, crossed)
    structure = jnp.concatenate([directions.T, torques[None]])
    null = _null_vector(structure)
    weight = jnp.stack([jnp.zeros_like(gravity), gravity, jnp.zeros_like(gravity)])
    balancing = jnp.linalg.pinv(structure) @ (body.mass * weight)

    # Every cable bounds the free parameter from one side; a cable that it doesn't stretch
    # has to hold by itself.
    still = jnp.abs(null) <= 8 * jnp.finfo(null.dtype).eps * jnp.abs(null).max()
    bound = (minimum_tension - balancing) / jnp.where(still, 1.0, null)
    lowest = jnp.max(jnp.where(~still & (null > 0), bound, -jnp.inf))
    highest = jnp.min(jnp.where(~still & (null < 0), bound, jnp.inf))
    held = jnp.all(~still | (balancing >= minimum_tension)) & (lowest <= highest)

    # The largest of four straight lines is least at an end of the range or at a crossing.
    crossings = [
        _ratio(balancing[i] - balancing[j], null[j] - null[i])
        for i, j in itertools.combinations(range(4), 2)
    ]
    places = jnp.clip(jnp.stack([*crossings, lowest, highest]), lowest, highest)
    tensions = jnp.where(
        jnp.isfinite(places), jnp.max(balancing + places[:, None] * null, axis=1), jnp.inf
    )
    size = jnp.stack([frame.width, frame.height])
    inside = jnp.all((position > 0) & (position < size))
    return jnp.where(held & inside, jnp.min(tensions), jnp.inf)


def _cables(
    robot: Robot,
    position: Float[Array, "2"],
    end_effector_width: Float[Array, ""],
    crossed: bool,
) -> tuple[Float[Array, "4 2"], Float[Array, "4"]]:
    """Directions of the cables' pulls on the end-effector, and their lever arms."""
    frame, body = robot.frame, robot.end_effector
    half, below, above = end_effector_width / 2, -body.lower_offset, body.upper_offset
    zero = jnp.zeros_like(half)
    first, second = (above, below) if crossed else (below, above)
    attachments = jnp.stack(
        [
            jnp.stack([-half, first]),
            jnp.stack([half, first]),
            jnp.stack([half, second]),
            jnp.stack([-half, second]),
        ]
    )
    corners = jnp.stack(
        [
            jnp.stack([zero, zero]),
            jnp.stack([frame.width, zero]),
            jnp.stack([frame.width, frame.height]),
            jnp.stack([zero, frame.height]),
        ]
    )
    cables = corners - position - attachments
    directions = cables / jnp.linalg.norm(cables, axis=1, keepdims=True)
    torques = attachments[:, 0] * directions[:, 1] - attachments[:, 1] * directions[:, 0]
    return directions, torques


def _null_vector(structure: Float[Array, "3 4"]) -> Float[Array, "4"]:
    """What spans the null space, by minors; of the sign that stretches the most cables."""
    columns = range(4)
    minors = jnp.stack(
        [
            (-1) ** i
            * jnp.linalg.det(structure[:, jnp.asarray([j for j in columns if j != i])])
            for i in columns
        ]
    )
    return minors * jnp.where(jnp.sum(jnp.sign(minors)) < 0, -1.0, 1.0)


def _ratio(above: Float[Array, ""], below: Float[Array, ""]) -> Float[Array, ""]:
    """Quotient; 0 where two lines are parallel and don't cross."""
    return jnp.where(below == 0, 0.0, above / jnp.where(below == 0, 1.0, below))
