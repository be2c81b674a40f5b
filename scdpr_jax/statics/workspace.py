"""The static workspace of the robot with a single cable loop, Eq. (1)."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot


class Region(eqx.Module):
    """A rectangle of end-effector positions, its border included."""

    lowest: Float[Array, "... 2"] = eqx.field(converter=real, metadata=si("m"))
    """Smallest $[x_e, y_e]$ [m]."""
    highest: Float[Array, "... 2"] = eqx.field(converter=real, metadata=si("m"))
    """Largest $[x_e, y_e]$ [m]; below the smallest, the region is empty."""

    @property
    def area(self) -> Float[Array, "..."]:
        """Area [m²], 0 if it is empty."""
        return jnp.prod(jnp.maximum(self.highest - self.lowest, 0), axis=-1)

    def contains(self, position: Float[Array, "2"]) -> Bool[Array, ""]:
        """Whether a position lies in the region.

        Args:
            position: Position $[x_e, y_e]$ of the end-effector [m].

        Returns:
            True within or on the border.
        """
        return jnp.all((self.lowest <= position) & (position <= self.highest))


def static_workspace(robot: Robot) -> Region:
    r"""Where the end-effector can be held with its carriages aligned, Eq. (1).

    $$ \frac{w_c}{2} \le x_e \le W - \frac{w_c}{2}, \qquad a \le y_e \le H - b $$

    with $a$ the lower and $b$ the upper offset, as in Eqs. (4)-(20): section 2.3 and Eq. (1)
    name them the other way round, see `docs/errata.md`. $w_c$ is the wider carriage's
    width; the paper prints the lower one's, and its two are equal. No tension limits it.

    Args:
        robot: The robot.

    Returns:
        The region.
    """
    widest = jnp.maximum(robot.lower_carriage.width, robot.upper_carriage.width)
    return _inside_frame(robot, half_width=widest / 2)


def geometric_region(robot: Robot, *, end_effector_width: Float[Array, ""]) -> Region:
    r"""Where the upright end-effector lies inside the frame, tensions apart.

    $$ \frac{w}{2} \le x_e \le W - \frac{w}{2}, \qquad a \le y_e \le H - b $$

    Args:
        robot: The robot.
        end_effector_width: Width $w$ of the end-effector [m]; 0.287 in Table 1.

    Returns:
        The region.
    """
    return _inside_frame(robot, half_width=end_effector_width / 2)


def frame_share(robot: Robot) -> Float[Array, ""]:
    """Share of the frame's area that the static workspace takes: 65.1 % with Table 1.

    Args:
        robot: The robot.

    Returns:
        Share, from 0 to 1 [1].
    """
    return static_workspace(robot).area / (robot.frame.width * robot.frame.height)


def reachable_share(robot: Robot, *, end_effector_width: Float[Array, ""]) -> Float[Array, ""]:
    """Share of the geometrically reachable positions that the static workspace has.

    The fair figure to compare robots by: the frame's border is out of reach for any of
    them. Here only carriages wider than the end-effector take something away.

    Args:
        robot: The robot.
        end_effector_width: Width of the end-effector [m]; 0.287 in Table 1.

    Returns:
        Share, from 0 to 1 [1]; not a number if the end-effector is wider than the frame.
    """
    static = static_workspace(robot)
    reachable = geometric_region(robot, end_effector_width=end_effector_width)
    common = Region(
        lowest=jnp.maximum(static.lowest, reachable.lowest),
        highest=jnp.minimum(static.highest, reachable.highest),
    )
    return common.area / reachable.area


def _inside_frame(robot: Robot, *, half_width: Float[Array, ""]) -> Region:
    low, high = robot.heights
    return Region(
        lowest=jnp.stack([half_width, low]),
        highest=jnp.stack([robot.frame.width - half_width, high]),
    )
