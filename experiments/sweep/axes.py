"""Axes of a sweep, as people write them."""

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from identification.campaign.quantities import QuantityError, parse_quantity
from scdpr_jax.robot.parameters import Robot


class Variable(NamedTuple):
    """Something that a sweep can vary."""

    name: str
    """Its name, also the coordinate's."""
    unit: str
    """SI unit."""
    meaning: str
    """What it is."""
    default: Callable[[Robot], Any]
    """Its value where it isn't swept, which the robot may know [in `unit`]."""
    positive: bool | None = True
    """Whether it must be above zero; False: it may be zero, None: it may have any sign."""


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


def parse_axes(texts: Sequence[str], variables: Sequence[Variable]) -> tuple[Axis, ...]:
    """The axes of a sweep from their texts.

    Args:
        texts: Each `NAME=LOW..HIGH:COUNT UNIT`, evenly spaced with both ends, or
            `NAME=VALUE, VALUE, … UNIT`; without a unit where it is 1.
        variables: What can vary.

    Returns:
        The axes.

    Raises:
        ValueError: If there is none, one isn't an axis, names nothing known or what another
            one has named, or has values out of range.
    """
    axes = tuple(_axis(text, variables) for text in texts)
    names = [axis.variable.name for axis in axes]
    if not axes or len(set(names)) != len(names):
        raise QuantityError(
            "axes that can't span a grid",
            name="--over",
            got=", ".join(names) or "none",
            expected="one axis or more, each once",
            remedy=f"Choose from: {', '.join(v.name for v in variables)}.",
        )
    return axes


def _axis(text: str, variables: Sequence[Variable]) -> Axis:
    name, _, written = (part.strip() for part in text.partition("="))
    variable = next((v for v in variables if v.name == name), None)
    if variable is None:
        raise QuantityError(
            "no such axis",
            name="--over",
            got=repr(text),
            expected=f"one of: {', '.join(v.name for v in variables)}",
            remedy='Write it like "y=0.2..0.9:50 m".',
        )
    values = _values(written, variable)
    if not _allowed(values, variable):
        raise QuantityError(
            "out of range",
            name=f"--over {name}",
            got=repr(written),
            expected=f"values {'above' if variable.positive else 'of or above'} 0",
            remedy=f"It is: {variable.meaning} [{variable.unit}].",
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


def _allowed(values: Float[np.ndarray, " points"], variable: Variable) -> bool:
    if variable.positive is None:
        return True
    return bool(np.all(values > 0 if variable.positive else values >= 0))


def _values(written: str, variable: Variable) -> Float[np.ndarray, " points"]:
    name = f"--over {variable.name}"

    def scaled(number: str, unit: str) -> float:
        return parse_quantity(f"{number} {unit}", unit=variable.unit, name=name)

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
        name=name,
        got=repr(written),
        expected="LOW..HIGH:COUNT UNIT with LOW below HIGH and COUNT 2 or more, or "
        "VALUE, VALUE UNIT",
        remedy=f'Write it like "{variable.name}=0.2..0.9:50{unit}" or '
        f'"{variable.name}=0.2, 0.9{unit}".',
    )
