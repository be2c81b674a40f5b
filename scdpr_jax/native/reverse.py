r"""Reverse mode by few numbers, as forward mode by each of them.

A cotangent pulled back through a run is a product with the run's Jacobian,
$\bar x = J^T \bar y$. Where x is a robot's parameters or a start, J has so few columns that
pushing all of them forward is done long before XLA has compiled the reverse program of a step,
which takes it half a minute and more. By many numbers, such as the inputs of all steps, reverse
mode is what it should be.
"""

import itertools
import math
from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
from jax.interpreters import ad
from jaxtyping import Array, Float

MOST = 256
"""Numbers of a robot up to which each is pushed forward by itself."""
TOGETHER = 20
"""Numbers that are pushed forward at a time, so that no Jacobian of a long run is whole."""

Seed = jax.Array | ad.UndefinedPrimal
"""Tangents behind axes of robots and of tangents, or what is to be found of them."""
Shapes = tuple[tuple[int, ...] | None, ...]
"""Of seeds without robots and tangents; none of those that are known."""


def wanted(seeds: Sequence[Seed]) -> Shapes | None:
    """What is to be found, if it is few numbers.

    Args:
        seeds: The seeds.

    Returns:
        Shapes of the seeds; none if reverse mode had better be what it is.
    """
    shapes = tuple(
        tuple(own.aval.shape[2:]) if ad.is_undefined_primal(own) else None for own in seeds
    )
    return shapes if sum(map(_size, shapes)) <= MOST else None


def _size(shape: tuple[int, ...] | None) -> int:
    return 0 if shape is None else math.prod(shape)


def contracted(
    slopes: Callable[[list[Array]], list[Float[Array, "robots ..."]]],
    seeds: Sequence[tuple[int, ...]],
    cotangents: Sequence[Float[Array, "robots ..."]],
    *,
    wanted: Shapes,
) -> list[Array | None]:
    """Cotangents of seeds, for each robot and each cotangent.

    Args:
        slopes: Derivatives along seeds, with the tangents last.
        seeds: Shapes of all seeds.
        cotangents: Cotangents of the derivatives, several of them last.
        wanted: Shapes of those that are to be found.

    Returns:
        What is found of each seed; None of a known one.
    """
    sizes = [*map(_size, wanted)]
    ends = [*itertools.accumulate(sizes, initial=0)]
    parts = -(-ends[-1] // TOGETHER) or 1
    wide = -(-ends[-1] // parts) or 1
    dtype = cotangents[0].dtype

    def part(number: Array) -> Float[Array, "robots cotangents wide"]:
        columns = jnp.arange(wide) + wide * number

        def along(shape: tuple[int, ...], first: int, size: int) -> Array:
            full = (1, wide, *shape)
            if not size:
                return jnp.zeros(full, dtype)
            rows = jnp.arange(first, first + size)
            return (columns[:, None] == rows[None, :]).astype(dtype).reshape(full)

        pushed = slopes([along(*of) for of in zip(seeds, ends[:-1], sizes, strict=True)])
        pairs = zip(pushed, cotangents, strict=True)
        return sum(jnp.einsum("rnp,rnt->rtp", _flat(x), _flat(y)) for x, y in pairs)

    found = jax.lax.map(part, jnp.arange(parts))
    found = jnp.moveaxis(found, 0, 2).reshape(*found.shape[1:3], -1)
    return [
        None
        if shape is None
        else found[:, :, first : first + size].reshape(*found.shape[:2], *shape)
        for shape, first, size in zip(wanted, ends[:-1], sizes, strict=True)
    ]


def _flat(x: Float[Array, "robots ... last"]) -> Float[Array, "robots all last"]:
    return x.reshape(x.shape[0], -1, x.shape[-1])


def summed(found: Array, shape: tuple[int, ...]) -> Array:
    """A seed's cotangent: a sum over robots or tangents where all share the seed.

    Args:
        found: Cotangents for each robot and each tangent.
        shape: The seed's shape.

    Returns:
        The cotangent, of that shape.
    """
    shared = [i for i in (0, 1) if shape[i] < found.shape[i]]
    return jnp.sum(found, shared, keepdims=True)
