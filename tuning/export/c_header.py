"""`scdpr_controller.h`: the sampled controller and the shapers in C99."""

import dataclasses
import math

from scdpr_jax.shaper import Shaper
from tuning.export.description import Constants, Description, decimal
from tuning.export.template import fill_in
from tuning.types import Range, RegionalShaper

FILE = "scdpr_controller.h"
"""The file's name."""


def c_header(description: Description) -> str:
    """The controller and the shapers as a self-contained C99 header.

    Functions are `static inline` on states that the caller owns; tables are `static const`.
    The controller is `scdpr_jax.controller.PD` with `saturate`, a shaper step is one sample
    of `scdpr_jax.shaper.shape_samples`: an impulse between two samples takes its share of
    both.

    Args:
        description: What is exported.

    Returns:
        C99 text.
    """
    period = description.constants.period
    shapers = description.shapers
    tables = [
        _table(number, regional.shaper, period) for number, regional in enumerate(shapers)
    ]
    regions = [_region(number, regional) for number, regional in enumerate(shapers)]
    return fill_in(
        FILE,
        constants="\n".join(_define(description.constants, field) for field in _FIELDS),
        region_count=str(len(shapers)),
        history=str(max(_history(regional.shaper, period) for regional in shapers)),
        tables="\n".join(tables),
        regions="\n".join(regions),
    )


_FIELDS = dataclasses.fields(Constants)


def _define(constants: Constants, field: dataclasses.Field) -> str:
    value = decimal(getattr(constants, field.name))
    return f"#define SCDPR_{field.name.upper()} {value} /* [{field.metadata['unit']}] */"


def _history(shaper: Shaper, period: float) -> int:
    """Samples from the latest one back to the second that the last impulse takes."""
    return math.floor(float(shaper.duration) / period) + 2


def _table(number: int, shaper: Shaper, period: float) -> str:
    rows = [
        _impulse(float(time) / period, float(amplitude), float(time))
        for time, amplitude in zip(shaper.times, shaper.amplitudes, strict=True)
    ]
    head = f"static const scdpr_impulse scdpr_impulses_{number}[{len(rows)}] = {{"
    return "\n".join([head, *rows, "};"])


def _impulse(delay: float, amplitude: float, time: float) -> str:
    whole = math.floor(delay)
    # The difference is exact: both are within a factor of two, or the whole part is zero.
    fraction = delay - whole
    cells = f"{whole}, {decimal(fraction)}, {decimal(amplitude)}"
    return f"    {{{cells}}}, /* {decimal(time)} s */"


def _region(number: int, regional: RegionalShaper) -> str:
    region = regional.region
    spans = ", ".join(_span(span) for span in (region.x, region.y, region.pretension))
    count = regional.shaper.times.size
    return f"    {{{spans}, {count}, scdpr_impulses_{number}}},"


def _span(span: Range) -> str:
    return "{" + ", ".join(decimal(end) for end in span) + "}"
