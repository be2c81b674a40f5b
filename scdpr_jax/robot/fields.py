"""Fields of the frozen data types: floating-point leaves that know their unit."""

import dataclasses
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.stated.units import si as si

Tree = TypeVar("Tree")


def real(value: Any) -> Float[Array, "..."]:
    """A number or array-like as a floating-point array of the default precision.

    Args:
        value: Anything `jax.numpy.asarray` takes; integers and booleans become floats.

    Returns:
        The same numbers; arrays that are floating already keep their precision.
    """
    # Numbers become floating in NumPy, which compiles nothing.
    array = np.asarray(value) if isinstance(value, _NUMBERS) else jnp.asarray(value)
    floating = jnp.issubdtype(array.dtype, jnp.floating)
    # An explicit type also strips weak typing, which would make a second call recompile.
    return jnp.asarray(array, dtype=array.dtype if floating else float)


_NUMBERS = (bool, int, float, np.ndarray, np.generic)


def concrete(array: Float[Array | np.ndarray, "..."]) -> Float[Array | np.ndarray, "..."]:
    """The numbers of an array as NumPy's, which computes without compiling anything.

    Args:
        array: The array.

    Returns:
        Its numbers; a traced array, which has none yet, as it is.
    """
    return array if isinstance(array, jax.core.Tracer) else np.asarray(array)


def refuse(
    value: Tree, refused: Bool[Array | np.ndarray, "..."] | np.bool_, message: str
) -> Tree:
    """A value that must not be used where a condition holds.

    A program with a check inside calls back to Python, and such a program is never kept in
    JAX's cache: so what is known is checked at once, and what is traced turns into NaN, which
    whoever looks at the result sees.

    Args:
        value: Arrays, in any tree.
        refused: Whether any of them is wrong, see `concrete`.
        message: What is wrong, where, what was expected, and what to do.

    Returns:
        The value; NaN throughout where it is traced and wrong.

    Raises:
        ValueError: If it is known to be wrong.
    """
    if not isinstance(refused, jax.core.Tracer):
        if np.any(np.asarray(refused)):
            raise ValueError(message)
        return value
    wrong = jnp.any(refused)
    return jax.tree.map(
        lambda leaf: jnp.where(wrong, jnp.nan, leaf) if eqx.is_inexact_array(leaf) else leaf,
        value,
    )


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
