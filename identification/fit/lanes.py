"""Many simulations of runs with one compiled function, side by side on every core."""

from collections.abc import Callable, Sequence
from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.data.record import MotorRecord, Record
from scdpr_jax.native import kept_jit
from scdpr_jax.numerics.side_by_side import kind_of, side_by_side
from scdpr_jax.robot.parameters import Robot

Result = TypeVar("Result")
RunFunction = Callable[[Robot, tuple[str, ...], Float[Array, " n"], Record], Result]
"""A function of a robot with its fixed quantities, the names of the free ones, these as the fit
holds them with the run's circumstances, and the run."""


@kept_jit
def over_lanes(
    function: RunFunction[Result],
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "lanes n"],
    run: Int[Array, " lanes"],
    records: Record | MotorRecord,
) -> Result:
    """A function of several simulations, compiled for their number.

    Args:
        function: What to compute of a simulation.
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: For each lane its run's free quantities and its circumstances.
        run: Which of the runs each lane is.
        records: The runs.

    Returns:
        The results, stacked.
    """

    def lane(unknown: Float[Array, " n"], number: Int[Array, ""]) -> Result:
        return function(robot, free, unknown, jax.tree.map(lambda leaf: leaf[number], records))

    return jax.vmap(lane)(unknowns, run)


def in_lanes(
    function: RunFunction[Result],
    robot: Robot,
    free: tuple[str, ...],
    vectors: Float[np.ndarray, "count n"],
    run: Sequence[int],
    records: Record,
    *,
    size: int,
) -> Result:
    """A function of any number of simulations, compiled once.

    Args:
        function: What to compute of a simulation.
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
        return over_lanes(function, robot, free, *map(jnp.asarray, lanes), records)

    return side_by_side(
        chunk,
        (np.asarray(vectors), np.asarray(run)),
        size=size,
        program=(function, kind_of((robot, free, records))),
    )
