"""Keeping XLA's CPU back end from computing a value anew for each of its uses.

A step of the engine is a long chain of cheap scalars, each used several times. XLA fuses a
cheap value into all of its uses and computes it in each, and a chain of those doubles with
every link. `jax.lax.optimization_barrier` would say it plainly and is removed before the
fusion. A division is too dear to be doubled, so what is to be computed once passes through
one.
"""

import jax
import jax.numpy as jnp
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float


def once(value: Float[Array, "..."]) -> Float[Array, "..."]:
    """What it is given, to the bit, computed once however often it is used.

    XLA's CPU back end fuses a cheap value into each of its uses and computes it there; chains
    of such values grow without bounds. A division is too dear for that, so the value is
    divided by one, which XLA can't tell, but LLVM can: the division itself is gone in the
    end. Derivatives of either direction are wrapped likewise, in their own shape.

    Args:
        value: Any value.

    Returns:
        The same.
    """
    return _once_p.bind(value)


def _divided(value: Array) -> Array:
    one = jnp.ones((), value.dtype)
    return value / jax.lax.clamp(one, value, one)


_once_p = Primitive("once")
_once_p.def_impl(lambda value: value)
_once_p.def_abstract_eval(lambda value: value)
ad.deflinear2(_once_p, lambda cotangent, _: [_once_p.bind(cotangent)])
batching.primitive_batchers[_once_p] = lambda values, axes: (_once_p.bind(*values), axes[0])
mlir.register_lowering(_once_p, mlir.lower_fun(_divided, multiple_results=False))
