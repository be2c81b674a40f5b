"""Many simulations of runs with one compiled function, side by side on every core."""

from collections.abc import Callable, Sequence
from typing import TypeVar

import jax
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


LANES = 8
"""Simulations of a chunk, whatever a campaign and a machine have: those of a vector."""


@kept_jit
def over_lanes(
    function: RunFunction[Result],
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array | np.ndarray, "lanes n"],
    records: Record | MotorRecord,
) -> Result:
    """A function of several simulations, compiled for their number.

    Args:
        function: What to compute of a simulation.
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: For each lane its run's free quantities and its circumstances.
        records: For each lane its run.

    Returns:
        The results, stacked.
    """
    return jax.vmap(lambda *lane: function(robot, free, *lane))(unknowns, records)


def in_lanes(
    function: RunFunction[Result],
    robot: Robot,
    free: tuple[str, ...],
    vectors: Float[np.ndarray, "count n"],
    run: Sequence[int],
    records: Record | MotorRecord,
    *,
    size: int = LANES,
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
    records = jax.tree.map(np.asarray, records)

    def chunk(
        lanes: tuple[Float[np.ndarray, "lanes n"], Int[np.ndarray, " lanes"]],
    ) -> Result:
        unknowns, rows = lanes
        own = jax.tree.map(lambda leaf: leaf[rows], records)
        return over_lanes(function, robot, free, unknowns, own)

    return side_by_side(
        chunk,
        (np.asarray(vectors), np.asarray(run)),
        size=size,
        program=(function, kind_of((robot, free, records))),
    )
