"""The paper's claim on stiffness: both robots over the workspace at one pretension."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.paper.topics.workspaces.numbers import GRAVITY
from scdpr_jax.linear.modes import BOTH_HELD, LOWER_HELD
from scdpr_jax.linear.stiffness import four_cable_stiffness, horizontal_stiffness
from scdpr_jax.robot.loop_elasticity import consistent_section
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.statics.four_cables import least_tensions

TENSION = 350.0
"""Pretension of the loop, and least tension of the four cables [N]."""

CLEAR = 0.05
"""Least distance between end-effector and frame of the poses that are compared [m]."""

_COLUMNS, _ROWS = 41, 31
_WIDTH = 0.287


class Stiffness(NamedTuple):
    """Horizontal stiffness over the workspace, carriages and motors held."""

    x: Float[np.ndarray, " columns"]
    """Horizontal positions [m]."""
    y: Float[np.ndarray, " rows"]
    """Heights [m]."""
    both_held: Float[np.ndarray, " rows"]
    """The single loop's with both carriages held [N/m]; the same in every column."""
    lower_held: Float[np.ndarray, " rows"]
    """The single loop's with the upper carriage free [N/m]."""
    conventional: Float[np.ndarray, "columns rows"]
    """The conventional robot's, open cables, motors held [N/m]."""

    @property
    def loop_ratio(self) -> float:
        """Largest over smallest of the single loop, both carriages held [1]."""
        return float(self.both_held.max() / self.both_held.min())

    @property
    def conventional_ratio(self) -> float:
        """Largest over smallest of the conventional robot [1]."""
        return float(np.nanmax(self.conventional) / np.nanmin(self.conventional))

    @property
    def advantage(self) -> float:
        """The conventional robot's over the single loop's in the middle [1]."""
        middle = self.conventional[_COLUMNS // 2, _ROWS // 2]
        return float(middle / self.both_held[_ROWS // 2])


@functools.cache
def stiffness_map() -> Stiffness:
    """Horizontal stiffness of both robots at one pretension.

    Returns:
        The maps.
    """
    robot = consistent()
    width = float(robot.frame.width)
    low, high = map(float, robot.heights)
    x = np.linspace(_WIDTH / 2 + CLEAR, width - _WIDTH / 2 - CLEAR, _COLUMNS)
    y = np.linspace(low + CLEAR, high - CLEAR, _ROWS)
    poses = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    both, lower, four = (np.asarray(part) for part in _maps(jnp.asarray(y), jnp.asarray(poses)))
    return Stiffness(x, y, both, lower, four.reshape(_COLUMNS, _ROWS))


@eqx.filter_jit
def _maps(
    heights: Float[Array, " rows"], poses: Float[Array, "poses 2"]
) -> tuple[Float[Array, " rows"], Float[Array, " rows"], Float[Array, " poses"]]:
    robot = replace(consistent(), {"effective_pretension": TENSION})
    both, lower = (
        jax.vmap(lambda height, held=held: horizontal_stiffness(robot, height, held))(heights)
        for held in (BOTH_HELD, LOWER_HELD)
    )

    def four(position: Float[Array, "2"]) -> Float[Array, ""]:
        width = jnp.asarray(_WIDTH)
        tensions = least_tensions(
            robot,
            position,
            end_effector_width=width,
            minimum_tension=jnp.asarray(TENSION),
            gravity=jnp.asarray(GRAVITY),
            crossed=False,
        )
        matrix = four_cable_stiffness(
            robot,
            position,
            end_effector_width=width,
            tensions=tensions,
            section=consistent_section(),
            crossed=False,
        )
        others = jnp.asarray([1, 2])
        coupling = matrix[0, others]
        giving = jnp.linalg.solve(matrix[jnp.ix_(others, others)], coupling)
        return matrix[0, 0] - coupling @ giving

    return both, lower, jax.vmap(four)(poses)
