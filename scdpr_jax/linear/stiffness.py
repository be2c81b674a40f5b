r"""Stiffness that an end-effector shows to a push: the single loop's and four cables'.

The single loop resists a horizontal push through its tension alone, as a string does; the
conventional robot resists it through its cables' elasticity, too.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.linear.model import stiffness_matrix
from scdpr_jax.linear.modes import Condition
from scdpr_jax.robot.loop_elasticity import CableSection
from scdpr_jax.robot.parameters import Robot


def horizontal_stiffness(
    robot: Robot, height: Float[Array, ""], condition: Condition
) -> Float[Array, ""]:
    r"""Horizontal force per displacement of the end-effector at an aligned pose, Eq. (20).

    $$ k = K_{xx} - K_{xo} K_{oo}^{-1} K_{ox} $$

    with $o$ what gives way to the push: the rotation, and the carriages that aren't held.

    Args:
        robot: The robot.
        height: Height $y_e$ of the end-effector [m].
        condition: What holds the carriages; a driven one counts as free, as for a push that
            lasts.

    Returns:
        Stiffness [N/m]; 0 where both carriages give way.
    """
    if condition.slides:
        return jnp.zeros_like(height)
    matrix = stiffness_matrix(robot, height)
    others = jnp.asarray(condition.moving[1:])
    coupling = matrix[0, others]
    return matrix[0, 0] - coupling @ jnp.linalg.solve(matrix[jnp.ix_(others, others)], coupling)


def cable_lengths(
    robot: Robot,
    pose: Float[Array, "3"],
    *,
    end_effector_width: Float[Array, ""],
    crossed: bool,
) -> Float[Array, "4"]:
    r"""Lengths of the conventional robot's four cables.

    Args:
        robot: Its frame and the offsets of its end-effector are taken.
        pose: Pose $[x_e, y_e, \delta_e]$, turned as in Eq. (4) [m, m, rad].
        end_effector_width: Distance of its left and right attachments [m].
        crossed: Whether the frame's lower corners hold the upper attachments, and the upper
            corners the lower ones.

    Returns:
        Lengths from the lower left corner round against the clock [m].
    """
    frame, body = robot.frame, robot.end_effector
    half, below, above = end_effector_width / 2, -body.lower_offset, body.upper_offset
    first, second = (above, below) if crossed else (below, above)
    across = jnp.stack([-half, half, half, -half])
    up = jnp.stack([first, first, second, second])
    # Positive turns carry the upper side to the left, the lower one to the right: Eq. (4).
    sine, cosine = jnp.sin(pose[2]), jnp.cos(pose[2])
    x = pose[0] + cosine * across - sine * up
    y = pose[1] + sine * across + cosine * up
    zero = jnp.zeros_like(frame.width)
    to_x = jnp.stack([zero, frame.width, frame.width, zero]) - x
    to_y = jnp.stack([zero, zero, frame.height, frame.height]) - y
    return jnp.sqrt(jnp.square(to_x) + jnp.square(to_y))


def four_cable_stiffness(
    robot: Robot,
    position: Float[Array, "2"],
    *,
    end_effector_width: Float[Array, ""],
    tensions: Float[Array, "4"],
    section: CableSection,
    crossed: bool,
) -> Float[Array, "3 3"]:
    r"""Stiffness of the conventional robot at an upright pose, its motors held.

    The Hessian of the elastic energy of four cables, each of its length at rest
    $\ell_i^0 = \ell_i / (1 + t_i / EA)$:

    $$ K = \nabla^2 \sum_i \frac{EA}{2 \ell_i^0} (\ell_i(q) - \ell_i^0)^2 $$

    Args:
        robot: Its frame and the offsets of its end-effector are taken.
        position: Position $[x_e, y_e]$ of the upright end-effector [m].
        end_effector_width: Distance of its left and right attachments [m].
        tensions: Tensions of the cables, as `cable_lengths` orders them [N].
        section: The cables.
        crossed: Whether the cables cross, see `cable_lengths`.

    Returns:
        Force against $[x_e, y_e, \delta_e]$ per displacement of each [N/m; N, N m for the
        rotation].
    """

    def lengths(pose: Float[Array, "3"]) -> Float[Array, "4"]:
        return cable_lengths(
            robot, pose, end_effector_width=end_effector_width, crossed=crossed
        )

    upright = jnp.concatenate([position, jnp.zeros_like(position[:1])])
    stiff = section.axial_stiffness
    slack = lengths(upright) / (1 + tensions / stiff)

    def energy(pose: Float[Array, "3"]) -> Float[Array, ""]:
        return jnp.sum(stiff / (2 * slack) * jnp.square(lengths(pose) - slack))

    return jax.hessian(energy)(upright)
