"""Many simulations with one compiled function, in chunks side by side on every core."""

import concurrent.futures
import functools
import os
from collections.abc import Callable, Hashable, Sequence
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PyTree

from identification.record import Record
from scdpr_jax.parameters import Robot

CORES = os.cpu_count() or 1
"""Chunks that are computed at the same time."""

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

    Computations that one thread asks for run one after the other, those of several threads
    at the same time.

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
    count = len(run)
    rows = np.minimum(np.arange(-(-count // size) * size), count - 1).reshape(-1, size)
    numbers = np.asarray(run)

    def chunk(own: Int[np.ndarray, " lanes"]) -> PyTree[np.ndarray]:
        given = jnp.asarray(vectors[own]), jnp.asarray(numbers[own])
        return jax.tree.map(np.asarray, function(robot, free, *given, records))

    found = []
    kind = (function, size, _kind((robot, free, records)))
    if kind not in _compiled:
        # Threads that find nothing compiled would all compile it.
        found, rows = [chunk(rows[0])], rows[1:]
        _compiled.add(kind)
    found += _threads().map(chunk, rows)
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *found)


_compiled: set[Hashable] = set()


def _kind(given: PyTree[Any]) -> Hashable:
    """What a compilation depends on: the structure, shapes and types, and what is no array."""
    leaves, structure = jax.tree.flatten(given)
    return structure, tuple(
        (np.shape(leaf), np.dtype(leaf.dtype)) if hasattr(leaf, "dtype") else leaf
        for leaf in leaves
    )


@functools.cache
def _threads() -> concurrent.futures.ThreadPoolExecutor:
    return concurrent.futures.ThreadPoolExecutor(CORES, "lanes")
