r"""Reverse mode by few numbers, as forward mode by each of them.

A cotangent pulled back through a run is a product with the run's Jacobian,
$\bar x = J^T \bar y$. Where x is a robot's parameters or a start, J has so few columns that
pushing all of them forward is done in less time than XLA takes to compile the reverse program
of a step (half a minute and more), and soon than that program runs: it has to do all steps
twice. By many numbers, such as the inputs of all steps, reverse mode is what it should be.
"""

import itertools
from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jax.interpreters import ad
from jaxtyping import Array, Float

MOST = 256
"""Numbers of a robot up to which each is pushed forward by itself."""
TOGETHER = 20
"""Numbers that are pushed forward at a time, so that no Jacobian of a long run is whole."""

Seed = jax.Array | ad.UndefinedPrimal
"""Tangents behind axes of robots and of tangents, or what is to be found of them."""


def is_short(seeds: Sequence[Seed]) -> bool:
    """Whether reverse mode by some seeds is forward mode by each.

    Args:
        seeds: The seeds.

    Returns:
        Whether there are few enough numbers to be found.
    """
    return sum(_size(own) for own in seeds if ad.is_undefined_primal(own)) <= MOST


def _shape(seed: Seed) -> tuple[int, ...]:
    """A seed's own shape, without robots and tangents."""
    return (seed.aval if ad.is_undefined_primal(seed) else seed).shape[2:]


def _size(seed: Seed) -> int:
    return int(np.prod(_shape(seed)))


def contracted(
    slopes: Callable[[list[Array]], list[Float[Array, "robots ..."]]],
    seeds: Sequence[Seed],
    cotangents: Sequence[Float[Array, "robots ..."]],
) -> list[Array | None]:
    """Cotangents of seeds, for each robot and each cotangent.

    Args:
        slopes: Derivatives along seeds, with the tangents last.
        seeds: The seeds, of which those that aren't known are to be found.
        cotangents: Cotangents of the derivatives, several of them last.

    Returns:
        What is found of each seed; None of a known one.
    """
    sizes = [_size(own) if ad.is_undefined_primal(own) else 0 for own in seeds]
    ends = [*itertools.accumulate(sizes, initial=0)]
    count = ends[-1]
    parts = -(-count // TOGETHER) or 1
    wide = -(-count // parts) or 1
    dtype = cotangents[0].dtype

    def part(number: Array) -> Float[Array, "robots cotangents wide"]:
        columns = jnp.arange(wide) + wide * number

        def along(seed: Seed, first: int, size: int) -> Array:
            rows = jnp.arange(first, first + size)
            unit = (columns[:, None] == rows[None, :]).astype(dtype)
            shape = (1, wide, *_shape(seed))
            return unit.reshape(shape) if size else jnp.zeros(shape, dtype)

        pushed = slopes([along(*of) for of in zip(seeds, ends[:-1], sizes, strict=True)])
        products = (
            jnp.einsum("rnp,rnt->rtp", _flat(x), _flat(c))
            for x, c in zip(pushed, cotangents, strict=True)
        )
        return sum(products)

    found = jax.lax.map(part, jnp.arange(parts))
    found = jnp.moveaxis(found, 0, 2).reshape(*found.shape[1:3], -1)
    return [
        found[:, :, first : first + size].reshape(*found.shape[:2], *_shape(seed))
        if size or ad.is_undefined_primal(seed)
        else None
        for seed, first, size in zip(seeds, ends[:-1], sizes, strict=True)
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
