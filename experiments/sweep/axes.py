"""Axes of a sweep, as people write them."""

import math
import re
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from identification.quantities import QuantityError, parse_quantity


class Variable(NamedTuple):
    """Something that a sweep can vary."""

    name: str
    """Its name, also the coordinate's."""
    unit: str
    """SI unit."""
    meaning: str
    """What it is."""
    default: float | None
    """Its value where it isn't swept [in `unit`]; None where the robot has it."""
    positive: bool = True
    """Whether it must be above zero."""


class Axis(NamedTuple):
    """One axis of a sweep."""

    variable: Variable
    """What varies."""
    values: Float[np.ndarray, " points"]
    """Its values, in the order given [in the variable's unit]."""


_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(
    rf"\s*(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER})\s*:\s*(?P<count>\d+)(?P<unit>.*)",
    re.ASCII,
)
_LIST = re.compile(
    rf"\s*(?P<numbers>{_NUMBER}(?:\s*,\s*{_NUMBER})*)(?![\d.])(?P<unit>.*)", re.ASCII
)


def parse_axis(text: str, variables: dict[str, Variable]) -> Axis:
    """An axis from its text.

    Args:
        text: `NAME=LOW..HIGH:COUNT UNIT`, evenly spaced with both ends, or
            `NAME=VALUE, VALUE, … UNIT`; without a unit where it is 1.
        variables: What can vary, by name.

    Returns:
        The axis.

    Raises:
        ValueError: If the text isn't one, names nothing known, or has values out of range.
    """
    name, _, written = (part.strip() for part in text.partition("="))
    if name not in variables:
        raise QuantityError(
            "no such axis",
            name="--over",
            got=repr(name),
            expected=f"one of: {', '.join(variables)}",
            remedy='Write it like "y=0.2..0.9:50 m".',
        )
    variable = variables[name]
    values = _values(written, variable, text)
    if not np.all(values > 0 if variable.positive else values >= 0):
        raise QuantityError(
            "out of range",
            name=f"--over {name}",
            got=repr(written),
            expected=f"values {'above' if variable.positive else 'of or above'} 0",
            remedy=f"It is the {variable.meaning} [{variable.unit}].",
        )
    if np.unique(values).size != values.size:
        raise QuantityError(
            "a value stands twice",
            name=f"--over {name}",
            got=repr(written),
            expected="values that differ",
            remedy="Leave one out.",
        )
    return Axis(variable, values)


def _values(written: str, variable: Variable, text: str) -> Float[np.ndarray, " points"]:
    def scaled(number: str, unit: str) -> float:
        return parse_quantity(
            f"{number} {unit}", unit=variable.unit, name=f"--over {variable.name}"
        )

    if found := _RANGE.fullmatch(written):
        low, high = (scaled(found[end], found["unit"]) for end in ("low", "high"))
        count = int(found["count"])
        if count >= 2 and low < high:
            return np.linspace(low, high, count)
    elif found := _LIST.fullmatch(written):
        return np.array([scaled(n, found["unit"]) for n in found["numbers"].split(",")])
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    raise QuantityError(
        "no values",
        name="--over",
        got=repr(text),
        expected="NAME=LOW..HIGH:COUNT UNIT with LOW below HIGH and COUNT 2 or more, or "
        "NAME=VALUE, VALUE UNIT",
        remedy=f'Write it like "{variable.name}=0.2..0.9:50{unit}" or '
        f'"{variable.name}=0.2, 0.9{unit}".',
    )


def rows(axes: tuple[Axis, ...], first: int, last: int) -> Float[np.ndarray, "points axes"]:
    """Points of the grid that axes span, the last axis the fastest.

    Args:
        axes: The axes.
        first: Index of the first point.
        last: Index after the last point.

    Returns:
        The points, one a row [in the axes' units].
    """
    shape = tuple(len(axis.values) for axis in axes)
    places = np.unravel_index(np.arange(first, last), shape)
    return np.stack([a.values[i] for a, i in zip(axes, places, strict=True)], axis=1)


def count(axes: tuple[Axis, ...]) -> int:
    """Number of points of the grid that axes span.

    Args:
        axes: The axes.

    Returns:
        The number.
    """
    return math.prod(len(axis.values) for axis in axes)
