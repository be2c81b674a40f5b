"""What a co-design is made for: legs of robots as they might be, at poses and settings."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax.robot.dynamics import State, rest
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot

OUT_OF_LINE = 0.3
"""Slope of the line between the carriages before a leg over what friction can hold [1]."""
_GOLDEN = (np.sqrt(5) - 1) / 2
"""Multiples of it, without their whole part, fill an interval evenly whatever their number."""


class Models(eqx.Module):
    """Horizontal legs from rest to rest, one a row; as NumPy arrays until they are run."""

    robot: Robot
    """The robots, stacked leaf by leaf."""
    start: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("m"))
    """Where the legs begin, $[x_e, y_e]$ [m]."""
    end: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("m"))
    """Where they end [m]."""
    slope: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1", r"\\tan\\gamma"))
    r"""Slope of the line between the carriages before the leg, within $\\pm\\mu$ [1]."""

    def __len__(self) -> int:
        return self.start.shape[0]

    def rows(self, rows: Int[np.ndarray, " n"]) -> "Models":
        """Some of the models.

        Args:
            rows: Which.

        Returns:
            These.
        """
        return jax.tree.map(lambda leaf: leaf[rows], self)


def models(
    robots: Sequence[Robot],
    *,
    begin: float,
    ends: Sequence[float],
    heights: Sequence[float],
) -> Models:
    """Every robot on every leg.

    Friction holds the carriages out of line after whatever leg came before: each model
    begins with its own slope, spread evenly over `OUT_OF_LINE` of what friction can hold.

    Args:
        robots: The robots, such as samples of a posterior at each pretension setting.
        begin: Where the legs begin [m].
        ends: Where they end [m]; the further, the faster, as all take the same time.
        heights: Their heights [m].

    Returns:
        The models: robots by heights by ends, the ends running fastest.
    """
    poses = [(end, height) for height in heights for end in ends]
    every = [(robot, *pose) for robot in robots for pose in poses]
    height = np.asarray([y for _, _, y in every])
    spread = 2 * np.mod(_GOLDEN * np.arange(1, len(every) + 1), 1.0) - 1
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *(robot for robot, _, _ in every))
    return Models(
        stacked,
        np.stack([np.full(len(every), begin), height], axis=1),
        np.stack([[x for _, x, _ in every], height], axis=1),
        OUT_OF_LINE * spread * np.asarray(stacked.upper_carriage.friction.coefficient),
    )


def resting(model: Any) -> State:
    """A model's robot before its leg, its end-effector where the leg begins.

    Args:
        model: One of the `Models`.

    Returns:
        The state.
    """
    x, y = model.start
    lower = x + model.slope * y
    return rest(model.robot, lower, lower - model.slope * model.robot.frame.height, y)
