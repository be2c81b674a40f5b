"""Many points through one function, the same way for every contender."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


def batched(
    function: Callable[[Array], Array], points: Float[np.ndarray, "points ..."], *, chunk: int
) -> Float[Array, "points ..."]:
    """A function of many points, some at a time, on one device.

    Not `scdpr_jax.batches`, which shares points out to devices by `jax.shard_map`: lineax,
    and with it every implicit solver, doesn't trace inside of that.

    Args:
        function: The function of a point; equal ones are compiled once.
        points: The points.
        chunk: Points at a time.

    Returns:
        The results, stacked.
    """
    return _all(function, jnp.asarray(points), chunk)


@eqx.filter_jit
def _all(function: Callable[[Array], Array], points: Array, chunk: int) -> Array:
    if chunk >= len(points):
        return jax.vmap(function)(points)
    return jax.lax.map(function, points, batch_size=chunk)
