"""Many computations with one compiled function, in chunks side by side on every core.

A step of the engine is too small for XLA to share it among cores, so each core gets a chunk
of its own, from a thread of its own. Devices for the cores (see `batches`) would need one
compilation each and have to be asked for before JAX starts, which a fit can't count on. What
takes longest is compiling, so chunks are of one size, and the first one is alone.
"""

import concurrent.futures
import functools
import os
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

import jax
import numpy as np
from jaxtyping import PyTree

CORES = os.cpu_count() or 1
"""Chunks that are computed at the same time."""

Lanes = TypeVar("Lanes")
Result = TypeVar("Result")


def side_by_side(
    function: Callable[[Lanes], Result], lanes: Lanes, *, size: int, program: Hashable
) -> Result:
    """A compiled function of any number of lanes.

    Computations that one thread asks for run one after the other, those of several threads
    at the same time. Functions that solve or decompose with LAPACK don't belong here: their
    kernels wait for the pool of threads that several of them fill.

    Args:
        function: What to compute of `size` lanes at once.
        lanes: What each lane is given, stacked, one at least, as NumPy arrays.
        size: Lanes of a chunk; the last chunk is filled up, so that one compilation serves
            any number.
        program: What the function's compilation depends on besides, such as `kind_of` what
            it closes over: the first chunk of every program compiles it alone.

    Returns:
        The results, stacked as the lanes are, as NumPy arrays.
    """
    count = len(jax.tree.leaves(lanes)[0])
    rows = np.minimum(np.arange(-(-count // size) * size), count - 1).reshape(-1, size)

    def chunk(chosen: np.ndarray) -> PyTree[np.ndarray]:
        part = jax.tree.map(lambda leaf: leaf[chosen], lanes)
        return jax.tree.map(np.asarray, function(part))

    results = []
    kind = (program, size, kind_of(jax.tree.map(lambda leaf: leaf[:1], lanes)))
    if kind not in _compiled:
        # Threads that find nothing compiled would all compile it.
        results, rows = [chunk(rows[0])], rows[1:]
        _compiled.add(kind)
    results += _threads().map(chunk, rows)
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[:count], *results)


_compiled: set[Hashable] = set()


def kind_of(given: PyTree[Any]) -> Hashable:
    """What a compilation depends on: the structure, shapes and types, and what is no array.

    Args:
        given: What a compiled function is given.

    Returns:
        Its kind.
    """
    leaves, structure = jax.tree.flatten(given)
    return structure, tuple(
        (np.shape(leaf), np.dtype(leaf.dtype)) if hasattr(leaf, "dtype") else leaf
        for leaf in leaves
    )


@functools.cache
def _threads() -> concurrent.futures.ThreadPoolExecutor:
    return concurrent.futures.ThreadPoolExecutor(CORES, "side-by-side")
