"""One function over many points, in chunks of fixed size.

Every chunk is run by the same program, the last one padded, so that a point gives the same
bits alone and among millions, on one device and on several: one program for all devices
together would round otherwise than a single device's. Only one chunk of points and results
is on a device at a time.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import equinox as eqx
import jax
import numpy as np
from jaxtyping import PyTree

Point = TypeVar("Point")
Result = TypeVar("Result")


def in_chunks(
    function: Callable[[Point], Result],
    points: Point,
    *,
    size: int,
    devices: Sequence[jax.Device] | None = None,
) -> Result:
    """A function of a single point, of many points.

    Args:
        function: What to compute of a point; arrays in, arrays out. What it closes over
            is compiled in: pass one function, not a new one for each call.
        points: Points, stacked along the leading axis of every leaf.
        size: Points that a device computes at a time.
        devices: Devices to share them; None for all of the host's.

    Returns:
        The results, stacked likewise, as NumPy arrays.

    Raises:
        ValueError: If there is no point, the leaves differ in length, or the size isn't
            positive.
    """
    count = _count(points)
    whole: list[np.ndarray] = []
    first, structure = 0, None
    for chunk in chunks(function, points, size=size, devices=devices):
        leaves, structure = jax.tree.flatten(chunk)
        if not whole:
            whole = [np.empty((count, *leaf.shape[1:]), leaf.dtype) for leaf in leaves]
        last = first + len(leaves[0])
        for target, leaf in zip(whole, leaves, strict=True):
            target[first:last] = leaf
        first = last
    return jax.tree.unflatten(structure, whole)


def chunks(
    function: Callable[[Point], Result],
    points: Point,
    *,
    size: int,
    devices: Sequence[jax.Device] | None = None,
) -> Iterator[Result]:
    """The results of `in_chunks`, one chunk after the other.

    Args:
        function: What to compute of a point.
        points: Points, stacked along the leading axis of every leaf.
        size: Points that a device computes at a time.
        devices: Devices to share them; None for all of the host's.

    Yields:
        Results of the next points: `size` for each device, the last time what is left.

    Raises:
        ValueError: If there is no point, the leaves differ in length, or the size isn't
            positive.
    """
    count = _count(points)
    if size < 1:
        raise ValueError(f"`size` must be 1 or more [points], got {size}.")
    used = tuple(jax.devices() if devices is None else devices)
    together = size * len(used)
    for first in range(0, count, together):
        # All are dispatched before any is waited for.
        begins = range(first, first + together, size)
        results = [
            _many(function, jax.device_put(_chunk(points, begin, size, count), device))
            for begin, device in zip(begins, used, strict=True)
        ]
        filled = min(together, count - first)
        yield jax.tree.map(
            lambda *leaves, filled=filled: np.concatenate(leaves)[:filled], *results
        )


def _chunk(points: Point, begin: int, size: int, count: int) -> Point:
    """Some points; after the last, the last again."""
    rows = np.minimum(np.arange(begin, begin + size), count - 1)
    return jax.tree.map(lambda leaf: np.asarray(leaf)[rows], points)


@eqx.filter_jit
def _many(function: Callable[[Point], Result], points: Point) -> Result:
    """The function of one chunk, on the device that has it."""
    return jax.vmap(function)(points)


def _count(points: PyTree) -> int:
    """Number of points."""
    lengths = {np.shape(leaf)[:1] for leaf in jax.tree.leaves(points)}
    if len(lengths) != 1 or lengths & {(), (0,)}:
        got = ", ".join(str(np.shape(leaf)) for leaf in jax.tree.leaves(points)) or "none"
        raise ValueError(
            "`points` must be arrays of one length along their leading axis, 1 or more "
            f"[points], got shapes: {got}. Stack the points, one a row."
        )
    return lengths.pop()[0]
