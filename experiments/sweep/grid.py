"""The grid that axes span: its points, and blocks of it that lie together."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from experiments.sweep.axes import Axis


class Grid(NamedTuple):
    """Every combination of the axes' values, the last axis the fastest."""

    axes: tuple[Axis, ...]
    """The axes."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(axis.variable.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of every axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def points(self, first: int, last: int) -> Float[np.ndarray, "points axes"]:
        """Some of the points in their order.

        Args:
            first: Index of the first point.
            last: Index after the last point.

        Returns:
            The points, one a row [in the axes' units].
        """
        places = np.unravel_index(np.arange(first, last), self.shape)
        columns = zip(self.axes, places, strict=True)
        return np.stack([axis.values[place] for axis, place in columns], axis=1)


class Block(NamedTuple):
    """Points that follow each other, and are a block of the grid as well."""

    first: int
    """Index of the first point."""
    last: int
    """Index after the last point."""
    place: tuple[int | slice, ...]
    """The block in an array of the grid's shape."""


def blocks(shape: tuple[int, ...], most: int) -> Iterator[Block]:
    """A grid cut into blocks that follow each other in the order of its points.

    Args:
        shape: Number of values of every axis.
        most: Points of a block at the most.

    Yields:
        The blocks; of the trailing axes each has all, of one a range, of the rest one value.
    """
    whole = next(n for n in range(len(shape) + 1) if math.prod(shape[n:]) <= most)
    inner = math.prod(shape[whole:])
    if whole == 0:
        yield Block(0, inner, (slice(None),) * len(shape))
        return
    step = most // inner
    first = 0
    for outer in np.ndindex(*shape[: whole - 1]):
        for low in range(0, shape[whole - 1], step):
            high = min(low + step, shape[whole - 1])
            last = first + inner * (high - low)
            yield Block(first, last, (*outer, slice(low, high)))
            first = last
