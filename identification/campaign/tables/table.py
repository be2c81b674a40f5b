"""A table of numbers in a CSV file: cells to SI units, every bad cell with its row.

Columns are converted at once. Only if that fails, or time doesn't increase, is the table
gone through cell by cell, to find where.
"""

import csv
import dataclasses
import io
import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import Fault, listed
from identification.campaign.quantities import LARGEST
from identification.campaign.tables.cells import Row, cell_faults, cell_number
from identification.campaign.tables.columns import Column, Scale
from identification.campaign.tables.header import Header, read_header
from identification.campaign.tables.text_file import read_text
from scdpr_jax.numerics.files.given import TABLE


@dataclasses.dataclass(frozen=True, eq=False)
class Table:
    """A stream's columns."""

    values: dict[str, Float64[np.ndarray, " rows"]]
    """Every known column that is there, by name [SI]; NaN for an empty cell."""
    units: dict[str, str]
    """The unit that each of them was written in."""
    extra: dict[str, Shaped[np.ndarray, " rows"]]
    """The other columns by header: numbers if all its cells are, text otherwise."""


def read_table(
    path: Path,
    expected: Sequence[Column],
    *,
    file: str,
    may_be_empty: bool = False,
    bare_extra: bool = False,
) -> tuple[Table | None, tuple[Fault, ...]]:
    """A stream's columns in SI units, and what is wrong with them.

    Args:
        path: The CSV file.
        expected: The columns that the stream may have, time among them as `t`.
        file: The file, relative to the campaign's folder.
        may_be_empty: Whether a cell other than time's may be empty.
        bare_extra: Whether a column that the format doesn't know may be without a unit.

    Returns:
        The table, None if there are faults; and the faults, at most about ten.
    """
    text, fault = read_text(path, most=TABLE)
    if fault is not None:
        return None, listed([fault], file=file)
    rows, broken = _rows(text)
    if not rows:
        return None, listed([broken or _too_short(rows)], file=file)
    (_, cells), *body = rows
    header, faults = read_header(cells, expected, bare_extra=bare_extra)
    if len(body) < 2 and broken is None:
        return None, listed([*faults, _too_short(rows)], file=file)
    if not header.columns:  # another dialect: its rows would only repeat that
        return None, listed(faults, file=file)
    if not faults and broken is None:
        table = _convert(header, body, may_be_empty=may_be_empty)
        if table is not None:
            return table, ()
    of_cells = cell_faults(header, body, may_be_empty=may_be_empty)
    every_fault = itertools.chain(faults, of_cells, [broken] if broken else [])
    return None, listed(every_fault, file=file)


def _rows(text: str) -> tuple[list[Row], Fault | None]:
    """The rows without the blank ones at the end, and what ended the reading early."""
    reader = csv.reader(io.StringIO(text, newline=""))
    rows: list[Row] = []
    broken = None
    try:
        rows.extend((reader.line_num, cells) for cells in reader)
    except csv.Error as error:
        broken = Fault(
            what="the row can't be split into cells",
            row=reader.line_num,
            got=str(error),
            expected="cells separated by commas",
            remedy="Look for a lone quotation mark, or a damaged part of the file.",
        )
    while rows and not any(cell.strip() for cell in rows[-1][1]):
        rows.pop()
    return rows, broken


def _too_short(rows: list[Row]) -> Fault:
    """The fault of a file without two samples."""
    return Fault(
        what="too few samples" if rows else "the file is empty",
        row=rows[-1][0] if rows else 1,
        got=("nothing", "a header only", "1 sample")[len(rows)],
        expected="a header and at least two samples",
        remedy="Export the log again; delete camera.csv if there was no camera.",
    )


def _convert(header: Header, body: list[Row], *, may_be_empty: bool) -> Table | None:
    """The table, None if there is a fault in it."""
    width = len(header.cells)
    if any(len(cells) != width for _, cells in body):
        return None
    columns = list(zip(*(cells for _, cells in body), strict=True))
    values, units = {}, {}
    for place, column in header.columns.items():
        empty = may_be_empty and column.name != "t"
        numbers = _numbers(columns[place], header.scale(place), may_be_empty=empty)
        if numbers is None or np.any(np.abs(numbers) > LARGEST):
            return None
        values[column.name], units[column.name] = numbers, header.units[place]
    if not np.all(np.diff(values["t"]) > 0):
        return None
    extra = {header.cells[place]: _extra(columns[place]) for place in header.extra}
    return Table(values, units, extra)


def _numbers(
    cells: Sequence[str], scale: Scale, *, may_be_empty: bool
) -> Float64[np.ndarray, " rows"] | None:
    """A column in SI units, None if a cell isn't a finite number."""
    numbers = _plain_numbers(cells, scale, may_be_empty=may_be_empty)
    if numbers is None:
        numbers = [cell_number(cell, scale, may_be_empty=may_be_empty) for cell in cells]
    return None if None in numbers else np.array(numbers, dtype=np.float64)


def _plain_numbers(
    cells: Sequence[str], scale: Scale, *, may_be_empty: bool
) -> list[float] | None:
    """The same, several times faster; None if a cell needs a closer look."""
    joined = "".join(cells)
    # What float() takes and the format doesn't: 1_000, other scripts' digits, nan, inf.
    if not joined.isascii() or any(mark in joined for mark in "_nN"):
        return None
    # The unit's power of ten goes into the text, so that the number is rounded once.
    power = f"e{scale.exponent}" if scale.exponent else ""
    try:
        numbers = [
            float(cell + power) if cell or not may_be_empty else math.nan for cell in cells
        ]
    except ValueError:
        return None
    if math.inf in numbers or -math.inf in numbers:
        return None
    return numbers if scale.factor == 1 else [number * scale.factor for number in numbers]


def _extra(cells: Sequence[str]) -> Shaped[np.ndarray, " rows"]:
    numbers = _numbers(cells, Scale(), may_be_empty=True)
    return np.array(cells, dtype=str) if numbers is None else numbers
