"""Many points through one function, the same way for every contender."""

from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.benchmarks.measurements.timing import fastest


def batched(
    function: Callable[[Array], Array], points: Float[np.ndarray, "points ..."], *, chunk: int
) -> Float[Array, "points ..."]:
    """A function of many points, some at a time, on one device.

    Not `scdpr_jax.numerics.batches`, which shares points among devices and brings every
    chunk back: what is timed is one compiled call.

    Args:
        function: The function of a point; equal ones are compiled once.
        points: The points.
        chunk: Points at a time.

    Returns:
        The results, stacked.
    """
    return _all(function, jnp.asarray(points), chunk)


def call(
    function: Callable[[Array], Array], points: Float[np.ndarray, "points ..."], chunk: int
) -> Callable[[], Float[Array, "points ..."]]:
    """`batched`, to be called later.

    Args:
        function: The function of a point.
        points: The points.
        chunk: Points at a time.

    Returns:
        What to call.
    """
    return lambda: batched(function, points, chunk=chunk)


def best_chunk(
    function: Callable[[Array], Array],
    points: Float[np.ndarray, "points ..."],
    chunks: Sequence[int],
    *,
    largest: int,
) -> int:
    """The number of points at a time with which a function is fastest.

    Args:
        function: The function of a point.
        points: Points to try it on, as many as the largest chunk.
        chunks: Numbers to try.
        largest: Largest number to try.

    Returns:
        The fastest.
    """
    tried = [chunk for chunk in chunks if chunk <= largest] or [1]
    if len(tried) == 1:
        return tried[0]
    return fastest({c: call(function, points[: max(tried)], c) for c in tried})


@eqx.filter_jit
def _all(function: Callable[[Array], Array], points: Array, chunk: int) -> Array:
    if chunk >= len(points):
        return jax.vmap(function)(points)
    return jax.lax.map(function, points, batch_size=chunk)
