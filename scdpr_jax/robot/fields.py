"""Fields of the frozen data types: floating-point leaves that know their unit."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.stated.units import si as si


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


def described(record: eqx.Module) -> str:
    """The numbers of a record with their names and units, on one line.

    Args:
        record: A record whose fields have a unit, or are such records.

    Returns:
        The line, without what is as it is by default.
    """
    parts = []
    for field in dataclasses.fields(record):
        content = getattr(record, field.name)
        if isinstance(content, eqx.Module):
            parts.append(f"{field.name} {type(content).__name__}({described(content)})")
        elif not (_concrete(content) and float(content) == field.default):
            parts.append(f"{field.name} {measured(content, field.metadata.get('unit', '1'))}")
    return ", ".join(parts)


def measured(number: Any, unit: str) -> str:
    """A number and its unit; an array of several, or a traced one, as its shape.

    Args:
        number: The number.
        unit: Its SI unit, "1" for none.

    Returns:
        The text.
    """
    text = f"{float(number):.4g}" if _concrete(number) else eqx.tree_pformat(number)
    return text if unit == "1" else f"{text} {unit}"


def _concrete(number: Any) -> bool:
    return isinstance(number, jax.Array | np.ndarray | float) and not (
        isinstance(number, jax.core.Tracer) or np.ndim(number)
    )
