"""Fields of the frozen data types: floating-point leaves that know their unit."""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float


def real(value: Any) -> Float[Array, "..."]:
    """A number or array-like as a floating-point array of the default precision.

    Args:
        value: Anything `jax.numpy.asarray` takes; integers and booleans become floats.

    Returns:
        The same numbers; arrays that are floating already keep their precision.
    """
    array = jnp.asarray(value)
    floating = jnp.issubdtype(array.dtype, jnp.floating)
    # An explicit type also strips weak typing, which would make a second call recompile.
    return jnp.asarray(array, dtype=array.dtype if floating else float)


def si(unit: str, symbol: str = "") -> dict[str, str]:
    """Metadata of a field: its SI unit and its symbol in the paper.

    Args:
        unit: SI unit as it is printed, "1" for none.
        symbol: Symbol in TeX, without dollars.

    Returns:
        What `equinox.field(metadata=...)` takes.
    """
    return {"unit": unit, "symbol": symbol}
