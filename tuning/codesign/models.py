"""What a co-design is made for: legs of robots as they might be, at poses and settings."""

from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax.legs.ensemble import Ensemble, stacked
from scdpr_jax.legs.starts import even_shares
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot

OUT_OF_LINE = 0.3
"""Slope of the line between the carriages before a leg over what friction can hold [1]."""


class Models(eqx.Module):
    """Horizontal legs from rest to rest, one a row; as NumPy arrays until they are run."""

    ensemble: Ensemble
    """The robots, at rest where their legs begin."""
    end: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("m"))
    """Where they end [m]."""

    def __len__(self) -> int:
        return len(self.ensemble)

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
    start = [(begin, y) for _, _, y in every]
    ensemble = stacked(
        [robot for robot, _, _ in every],
        start,
        out_of_line=OUT_OF_LINE * even_shares(len(every)),
    )
    return Models(ensemble, np.asarray([(x, y) for _, x, y in every]))
