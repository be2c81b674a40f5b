r"""The conventional planar robot of four cables, each on its own motor; section 2.1.

The cables run from the corners of the frame to those of an upright end-effector. It is
what the paper measures its own workspace against.
"""

import itertools

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.parameters import Robot


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

    $$ \min_t \max_i t_i \quad \text{with} \quad A t = [0, m g, 0]^T, \quad t_i \ge T_{min} $$

    The structure matrix $A$ (3 x 4) has a null space of one dimension, spanned by its
    minors $n$, so that $t = p + \lambda n$: the largest of four straight lines over an
    interval of $\lambda$. A pose lies in the static workspace for every $T_{max}$ from here
    on (wrench feasibility, doi:10.1109/TRO.2006.878967, of the weight alone).

    Args:
        robot: Its frame, and the mass and the offsets of its end-effector, are taken.
        position: Position $[x_e, y_e]$ of the upright end-effector [m].
        end_effector_width: Distance of its left and right attachments [m].
        minimum_tension: Least tension $T_{min}$ of every cable [N].
        gravity: Gravitational acceleration $g$ [m/s²].
        crossed: Whether the frame's lower corners hold the upper attachments, and the upper
            corners the lower ones.

    Returns:
        Tension [N]; infinity where the pose can't be held, or its centre isn't inside the
        frame.
    """
    structure = _structure_matrix(robot, position, end_effector_width, crossed)
    null = _minors(structure)
    lines = _balancing(structure, null, robot.end_effector.mass * gravity), null
    lowest, highest, held = _interval(*lines, minimum_tension)

    # The largest of straight lines is least at an end of the interval or at a crossing.
    crossings = [_crossing(*lines, i, j) for i, j in itertools.combinations(range(4), 2)]
    places = jnp.clip(jnp.stack([*crossings, lowest, highest]), lowest, highest)
    finite = jnp.isfinite(places)
    tensions = lines[0][None] + jnp.where(finite, places, 0)[:, None] * null[None]
    largest = jnp.where(finite, jnp.max(tensions, axis=1), jnp.inf)

    size = jnp.stack([robot.frame.width, robot.frame.height])
    inside = jnp.all((position > 0) & (position < size))
    return jnp.where(held & inside, jnp.min(largest), jnp.inf)


def least_tensions(
    robot: Robot,
    position: Float[Array, "2"],
    *,
    end_effector_width: Float[Array, ""],
    minimum_tension: Float[Array, ""],
    gravity: Float[Array, ""],
    crossed: bool,
) -> Float[Array, "4"]:
    r"""The smallest tensions that balance the weight with none below a minimum.

    $t = p + \lambda n$ with $n > 0$ spanning the null space of the structure matrix, and the
    least $\lambda$ that keeps every cable at the minimum.

    Args:
        robot: Its frame, and the mass and the offsets of its end-effector, are taken.
        position: Position $[x_e, y_e]$ of the upright end-effector [m].
        end_effector_width: Distance of its left and right attachments [m].
        minimum_tension: Least tension $T_{min}$ of every cable [N].
        gravity: Gravitational acceleration [m/s²].
        crossed: Whether the cables cross, see `needed_tension`.

    Returns:
        Tensions [N]; not numbers where the cables can't pull against each other.
    """
    structure = _structure_matrix(robot, position, end_effector_width, crossed)
    null = _minors(structure)
    balancing = _balancing(structure, null, robot.end_effector.mass * gravity)
    lowest, _, _ = _interval(balancing, null, minimum_tension)
    return jnp.where(jnp.all(null > 0), balancing + lowest * null, jnp.nan)


def _structure_matrix(
    robot: Robot,
    position: Float[Array, "2"],
    end_effector_width: Float[Array, ""],
    crossed: bool,
) -> Float[Array, "3 4"]:
    """Force and moment of a unit tension in each cable, from the lower left one on."""
    frame, body = robot.frame, robot.end_effector
    half, zero = end_effector_width / 2, jnp.zeros_like(end_effector_width)
    lower, upper = -body.lower_offset, body.upper_offset
    if crossed:
        lower, upper = upper, lower
    arm = jnp.stack([-half, half, half, -half]), jnp.stack([lower, lower, upper, upper])
    corner = (
        jnp.stack([zero, frame.width, frame.width, zero]),
        jnp.stack([zero, zero, frame.height, frame.height]),
    )
    across, up = (corner[axis] - position[axis] - arm[axis] for axis in (0, 1))
    length = jnp.hypot(across, up)
    moment = arm[0] * up - arm[1] * across
    return jnp.stack([across, up, moment]) / length[None]


def _minors(structure: Float[Array, "3 4"]) -> Float[Array, "4"]:
    """What spans the null space; of the sign that stretches the most cables."""
    column = structure.T
    minors = []
    for left_out in range(4):
        a, b, c = (column[i] for i in range(4) if i != left_out)
        minors.append((-1) ** left_out * jnp.dot(a, jnp.cross(b, c)))
    null = jnp.stack(minors)
    return null * jnp.where(jnp.sum(jnp.sign(null)) < 0, -1, 1).astype(null.dtype)


def _balancing(
    structure: Float[Array, "3 4"], null: Float[Array, "4"], weight: Float[Array, ""]
) -> Float[Array, "4"]:
    r"""The smallest tensions in the square that balance a weight, of either sign.

    $p = A^T G^{-1} w$ with $G = A A^T$; its determinant is the minors' sum of squares
    (Cauchy and Binet), the column of its inverse that meets a weight a cross product.
    """
    gram = structure @ structure.T
    return weight / jnp.dot(null, null) * (structure.T @ jnp.cross(gram[2], gram[0]))


def _interval(
    balancing: Float[Array, "4"], null: Float[Array, "4"], minimum: Float[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""], Bool[Array, ""]]:
    r"""The $\lambda$ at which every cable has the minimum, and whether there are any."""
    # A cable that the null space doesn't stretch has to hold by itself.
    still = jnp.abs(null) <= 8 * jnp.finfo(null.dtype).eps * jnp.max(jnp.abs(null))
    bound = (minimum - balancing) / jnp.where(still, 1, null)
    lowest = jnp.max(jnp.where(~still & (null > 0), bound, -jnp.inf))
    highest = jnp.min(jnp.where(~still & (null < 0), bound, jnp.inf))
    held = jnp.all(~still | (balancing >= minimum)) & (lowest <= highest)
    return lowest, highest, held


def _crossing(
    balancing: Float[Array, "4"], null: Float[Array, "4"], i: int, j: int
) -> Float[Array, ""]:
    r"""The $\lambda$ at which two cables have one tension; 0 if they always differ."""
    apart = null[j] - null[i]
    return jnp.where(
        apart == 0, 0, (balancing[i] - balancing[j]) / jnp.where(apart == 0, 1, apart)
    )
