"""Figures 3 and 6: where the conventional robot's tensions hold a pose, and Eq. (1)."""

import functools
import itertools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.statics.four_cables import needed_tension
from scdpr_jax.statics.workspace import Region, frame_share, geometric_region, static_workspace

PRINTED = {10.0: 0.7073, 50.0: 0.4156}
"""Share of the frame's area that section 2.1 prints for a least tension [N]."""

WIDTH, HEIGHT, MASS = 0.281, 0.287, 2.0
"""End-effector of section 2.1, which Figure 3 is drawn with [m, m, kg]."""

GRAVITY = 9.81
"""Gravitational acceleration [m/s²]."""

_GRID = (240, 120)


class Cables(NamedTuple):
    """The conventional robot's workspace for one way to lead the cables."""

    crossed: bool
    """Whether the cables cross."""
    minimum: float
    """Least tension $T_{min}$ [N]."""
    needed: Float[np.ndarray, "columns rows"]
    """Largest tension that a pose needs at least [N]; infinite where none holds it."""
    inside: Bool[np.ndarray, "columns rows"]
    """Whether the end-effector lies inside the frame."""

    @property
    def name(self) -> str:
        """What it is, for a legend."""
        return f"{'crossed' if self.crossed else 'open'} cables, T_min {self.minimum:g} N"

    def share(self, maximum: float) -> float:
        """Share of the frame's area that a largest tension reaches.

        Args:
            maximum: Largest tension $T_{max}$ [N].

        Returns:
            Share [1].
        """
        return float(np.mean(np.isfinite(self.needed) & (self.needed <= maximum)))

    def reachable_share(self, maximum: float) -> float:
        """Share of the poses inside the frame that a largest tension reaches.

        Args:
            maximum: Largest tension $T_{max}$ [N].

        Returns:
            Share [1].
        """
        needed = self.needed[self.inside]
        return float(np.mean(np.isfinite(needed) & (needed <= maximum)))

    def maximum_for(self, share: float) -> float:
        """Largest tension that a share of the frame's area needs.

        Args:
            share: The share [1].

        Returns:
            Tension [N]; infinite where no tension gives it.
        """
        ordered = np.sort(self.needed.ravel())
        return float(ordered[round(share * ordered.size) - 1])


class Workspaces(NamedTuple):
    """The workspaces of Figures 3 and 6."""

    x: Float[np.ndarray, " columns"]
    """Horizontal positions of the poses [m]."""
    y: Float[np.ndarray, " rows"]
    """Heights of the poses [m]."""
    cables: tuple[Cables, ...]
    """The conventional robot: open and crossed, least tension 10 and 50 N."""
    loop: Region
    """The single loop's, Eq. (1)."""
    loop_share: float
    """Its share of the frame's area [1]."""
    loop_reachable: float
    """Its share of the poses whose end-effector lies inside the frame [1]."""

    def of(self, *, crossed: bool, minimum: float) -> Cables:
        """The conventional robot's workspace.

        Args:
            crossed: Whether the cables cross.
            minimum: Least tension [N], 10 or 50.

        Returns:
            The workspace.
        """
        return next(c for c in self.cables if (c.crossed, c.minimum) == (crossed, minimum))


@functools.cache
def workspaces(width: float = WIDTH, height: float = HEIGHT) -> Workspaces:
    """Both robots' static workspaces, poses in the middles of 240 by 120 cells.

    Args:
        width: Width of the end-effector [m].
        height: Height of the end-effector [m].

    Returns:
        The workspaces.
    """
    table_1 = consistent()
    robot = replace(
        table_1,
        {"end_effector_mass": MASS, "lower_offset": height / 2, "upper_offset": height / 2},
    )
    frame = np.array([float(robot.frame.width), float(robot.frame.height)])
    x, y = (size * (np.arange(n) + 0.5) / n for size, n in zip(frame, _GRID, strict=True))
    poses = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    half = np.array([width, height]) / 2
    inside = np.all((poses >= half) & (poses <= frame - half), axis=-1)
    flat = jnp.asarray(poses.reshape(-1, 2))

    def cables(crossed: bool, minimum: float) -> Cables:
        needed = _needed(robot, flat, jnp.asarray(width), jnp.asarray(minimum), crossed)
        return Cables(crossed, minimum, np.asarray(needed).reshape(_GRID), inside)

    region = static_workspace(table_1)
    reachable = geometric_region(table_1, end_effector_width=jnp.asarray(0.287))
    return Workspaces(
        x,
        y,
        tuple(itertools.starmap(cables, itertools.product((False, True), PRINTED))),
        loop=region,
        loop_share=float(frame_share(table_1)),
        loop_reachable=float(region.area / reachable.area),
    )


@eqx.filter_jit
def _needed(
    robot: Robot,
    poses: Float[Array, "poses 2"],
    width: Float[Array, ""],
    minimum: Float[Array, ""],
    crossed: bool,
) -> Float[Array, " poses"]:
    return jax.vmap(
        lambda position: needed_tension(
            robot,
            position,
            end_effector_width=width,
            minimum_tension=minimum,
            gravity=jnp.asarray(GRAVITY),
            crossed=crossed,
        )
    )(poses)
