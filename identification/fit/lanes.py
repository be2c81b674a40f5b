"""Many simulations of runs with one compiled function, side by side on every core."""

from collections.abc import Callable, Sequence
from typing import TypeVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.data.record import Record
from scdpr_jax.numerics.side_by_side import kind_of, side_by_side
from scdpr_jax.robot.parameters import Robot

Result = TypeVar("Result")
Function = Callable[
    [Robot, tuple[str, ...], Float[Array, "lanes n"], Int[Array, " lanes"], Record], Result
]
"""A compiled function of a robot, its free quantities, and for each lane of these quantities
with the circumstances and the run that it is of; with the runs' records."""


def in_lanes(
    function: Function[Result],
    robot: Robot,
    free: tuple[str, ...],
    vectors: Float[np.ndarray, "count n"],
    run: Sequence[int],
    records: Record,
    *,
    size: int,
) -> Result:
    """A compiled function of any number of simulations.

    Args:
        function: What to compute of `size` simulations.
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        vectors: Free quantities and circumstances of each simulation, one at least.
        run: Which of the runs each of them is of.
        records: The runs.
        size: Simulations of a chunk; the last chunk is filled up, so that one compilation
            serves any number.

    Returns:
        The results, stacked as the vectors are, as NumPy arrays.
    """

    def chunk(
        lanes: tuple[Float[np.ndarray, "lanes n"], Int[np.ndarray, " lanes"]],
    ) -> Result:
        return function(robot, free, *map(jnp.asarray, lanes), records)

    return side_by_side(
        chunk,
        (np.asarray(vectors), np.asarray(run)),
        size=size,
        program=(function, kind_of((robot, free, records))),
    )
