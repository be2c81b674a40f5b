"""`scdpr_controller.h`: the sampled controller and the shapers in C99."""

import dataclasses
import math
from collections.abc import Sequence

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.provenance import Provenance
from scdpr_jax.robot.stated.ranges import SETTING_TOLERANCE
from tuning.export.description import Constants, Description, decimal
from tuning.export.template import fill_in
from tuning.regions.schedule import grids_of, handover_widths
from tuning.result.regional_shaper import Range, RegionalShaper

FILE = "scdpr_controller.h"
"""The file's name."""


def c_header(description: Description) -> str:
    """The controller and the shapers as a self-contained C99 header.

    Functions are `static inline` on states that the caller owns; tables are `static const`.
    The controller is `scdpr_jax.command.controller.PD` with `saturate`, a shaper step is one
    sample of `scdpr_jax.command.shaper.shape_samples`: an impulse between two samples takes its
    share of both. A schedule step is one of `tuning.regions.schedule.scheduled_samples`.

    Args:
        description: What is exported.

    Returns:
        C99 text.

    Raises:
        ValueError: If the regions of the shapers at a setting aren't a grid.
    """
    period = description.constants.period
    shapers = description.shapers
    tables = [
        _table(number, regional.shaper, period) for number, regional in enumerate(shapers)
    ]
    grids = grids_of(shapers)
    regions = [_region(number, regional, grids) for number, regional in enumerate(shapers)]
    return fill_in(
        FILE,
        constants="\n".join(
            [
                f"/* {_comment(description.provenance)} */",
                *_cautions(description),
                *(_define(description.constants, field) for field in _FIELDS),
            ]
        ),
        region_count=str(len(shapers)),
        tolerance=decimal(SETTING_TOLERANCE),
        history=str(max(_history(regional.shaper, period) for regional in shapers)),
        tables="\n".join(tables),
        regions="\n".join(regions),
    )


_FIELDS = dataclasses.fields(Constants)


def _comment(provenance: Provenance) -> str:
    """Where it comes from, whatever a campaign is called."""
    return str(provenance).replace("*/", "* /").replace("\\", "/")


def _cautions(description: Description) -> list[str]:
    """A warning for who reads the file, and one for who compiles it."""
    if not description.caution:
        return []
    return [f"/* {description.caution} */", "#define SCDPR_MODEL_DOES_NOT_FIT 1"]


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


def _region(
    number: int, regional: RegionalShaper, grids: dict[Range, tuple[RegionalShaper, ...]]
) -> str:
    region = regional.region
    here = [one.region for one in grids[region.pretension]]
    cells = [
        *(_span(span) for span in (region.x, region.y, region.pretension)),
        str(list(grids).index(region.pretension)),
        _handover(region.x, [one.x for one in here]),
        _handover(region.y, [one.y for one in here]),
        str(regional.shaper.times.size),
        f"scdpr_impulses_{number}",
    ]
    return f"    {{{', '.join(cells)}}},"


def _handover(span: Range, spans: Sequence[Range]) -> str:
    """Widths of the hand-overs at both ends of a stretch, 0 at an edge of the frame."""
    low, high = (handover_widths(spans).get(end, 0.0) for end in span)
    return _span((low, high))


def _span(span: Range) -> str:
    return "{" + ", ".join(decimal(end) for end in span) + "}"
