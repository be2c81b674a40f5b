"""`controller.csv` and `shapers.csv`: plain tables of numbers, as LabVIEW reads them."""

import csv
import dataclasses
import io
from collections.abc import Iterator

from tuning.export.description import Constants, Description, decimal
from tuning.result.regional_shaper import Region, RegionalShaper

CONTROLLER_FILE = "controller.csv"
"""Name of the table of the controller's numbers."""
SHAPERS_FILE = "shapers.csv"
"""Name of the table of impulses."""
CAUTION_COLUMN = "model_does_not_fit [1]"
"""Last column, of ones, of what is made from a fit that has failed."""


def controller_table(description: Description) -> str:
    """The controller's numbers as one row.

    Args:
        description: What is exported.

    Returns:
        CSV, units in the header as in the logs.
    """
    fields = dataclasses.fields(Constants)
    header = [f"{field.name} [{field.metadata['unit']}]" for field in fields]
    row = [decimal(getattr(description.constants, field.name)) for field in fields]
    return _csv([header, row], description)


def shapers_table(description: Description) -> str:
    """The impulses of every region's shaper, one a row.

    Args:
        description: What is exported.

    Returns:
        CSV, units in the header as in the logs; `region` counts from 0.
    """
    spans = [
        f"{field.name}_{end} [{field.metadata['unit']}]"
        for field in dataclasses.fields(Region)
        for end in ("low", "high")
    ]
    rows = [
        row
        for number, regional in enumerate(description.shapers)
        for row in _rows(number, regional)
    ]
    header = ["region [1]", *spans, "time [s]", "amplitude [1]"]
    return _csv([header, *rows], description)


def _rows(number: int, regional: RegionalShaper) -> Iterator[list[str]]:
    region, shaper = regional.region, regional.shaper
    ends = [decimal(end) for span in (region.x, region.y, region.pretension) for end in span]
    for time, amplitude in zip(shaper.times, shaper.amplitudes, strict=True):
        yield [str(number), *ends, decimal(time), decimal(amplitude)]


def _csv(rows: list[list[str]], description: Description) -> str:
    text = io.StringIO()
    if description.caution:
        # The last one: whoever reads columns by their place goes on reading the same.
        marks = (CAUTION_COLUMN, *("1" for _ in rows[1:]))
        rows = [[*row, mark] for row, mark in zip(rows, marks, strict=True)]
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
