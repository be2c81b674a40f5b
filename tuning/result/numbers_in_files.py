"""Numbers of `tuning.json` and `codesign.json` with their units, and what they can be.

The ranges are wide: what is outside them is a slip of a unit or of the file, and would give
commands that no drive takes or times that no leg has.
"""

from collections.abc import Sequence
from typing import Annotated, Literal

import pydantic

from scdpr_jax.numerics.json_file import JsonObject

Time = Annotated[float, pydantic.Field(ge=0, le=3600.0)]
"""A duration [s], an hour at most: more is a time stamp of the wall clock."""

Gain = Annotated[float, pydantic.Field(ge=0, le=1e6)]
"""A gain; one below zero drives away from its reference."""

Span = tuple[float, float]
"""Both ends of a range."""


class VoltsPerRadian(JsonObject):
    """A proportional gain."""

    value: Gain
    unit: Literal["V/rad"]


class VoltSecondsPerRadian(JsonObject):
    """A derivative gain."""

    value: Gain
    unit: Literal["V s/rad"]


class Seconds(JsonObject):
    """A duration."""

    value: Time
    unit: Literal["s"]


class SamplePeriod(JsonObject):
    """Period of a sampled controller."""

    value: Annotated[float, pydantic.Field(ge=1e-6, le=1.0)]
    unit: Literal["s"]


class Instants(JsonObject):
    """Times of impulses."""

    value: list[Time]
    unit: Literal["s"]


class Newtons(JsonObject):
    """A pretension's setting."""

    value: Annotated[float, pydantic.Field(ge=0, le=1e6)]
    unit: Literal["N"]


def check_impulses(times: Sequence[float], amplitudes: Sequence[float]) -> None:
    """Refuse what is no shaper.

    Args:
        times: Times of the impulses [s].
        amplitudes: Their amplitudes [1].

    Raises:
        ValueError: If there isn't one of both for each, they aren't in order, or the
            amplitudes are huge or don't sum to 1.
    """
    if not times or len(times) != len(amplitudes):
        raise ValueError(
            f"{len(times)} times and {len(amplitudes)} amplitudes, expected as many of both, "
            "one at least"
        )
    if list(times) != sorted(times):
        raise ValueError("the times decrease [s], expected them sorted")
    total, largest = sum(amplitudes), max(map(abs, amplitudes))
    if not (abs(total - 1) <= 1e-6 and largest <= 1e3):
        raise ValueError(
            f"the amplitudes sum to {total:.6g}, the largest is {largest:.6g}, expected a sum "
            "of 1 and none above 1000"
        )
