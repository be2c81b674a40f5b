"""A table of numbers in a CSV file: cells to SI units, every bad cell with its row.

Columns are converted at once, some thousand rows of them at a time. Only if that fails, or time
doesn't increase, is the table gone through cell by cell, to find where.
"""

import csv
import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import Fault, listed
from identification.campaign.quantities import LARGEST
from identification.campaign.tables.cells import cell_faults, cell_number
from identification.campaign.tables.columns import Column, Scale
from identification.campaign.tables.header import Header, read_header
from identification.campaign.tables.rows import Rows
from identification.campaign.tables.text_file import read_text_bytes
from scdpr_jax.numerics.files.given import TABLE

_WIDEST = 1000
"""Columns of a table, at the most."""


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
    content, fault = read_text_bytes(path, most=TABLE)
    if fault is not None:
        return None, listed([fault], file=file)
    rows = Rows(content)
    header, faults = _header(rows.first, expected, bare_extra=bare_extra)
    if not faults:
        table = _convert(header, rows, may_be_empty=may_be_empty)
        if table is not None:
            return table, ()
    return None, listed(_faults(header, faults, rows, may_be_empty=may_be_empty), file=file)


def _header(
    cells: Sequence[str], expected: Sequence[Column], *, bare_extra: bool
) -> tuple[Header, tuple[Fault, ...]]:
    """The header, and what is wrong with it; nothing of one that no log can have."""
    if len(cells) <= _WIDEST:
        return read_header(cells, expected, bare_extra=bare_extra)
    fault = Fault(
        what="too many columns",
        row=1,
        got=f"{len(cells):,} columns",
        expected=f"{_WIDEST:,} at most",
        remedy="Is it the right file? Delete the columns that aren't needed.",
    )
    return Header((), {}, {}, ()), (fault,)


def _faults(
    header: Header, faults: Sequence[Fault], rows: Rows, *, may_be_empty: bool
) -> Iterable[Fault]:
    """Everything that is wrong with a table, as far as it can be told."""
    count, broken = rows.extent
    if not count:
        return [broken or _too_short(rows)]
    if count < 3 and broken is None:
        return [*faults, _too_short(rows)]
    if not header.columns:  # another dialect: its rows would only repeat that
        return faults
    body = itertools.islice(rows.solid(), 1, None)
    of_cells = cell_faults(header, body, may_be_empty=may_be_empty)
    return itertools.chain(faults, of_cells, [broken] if broken else [])


def _too_short(rows: Rows) -> Fault:
    """The fault of a file without two samples."""
    lines = [line for line, _ in rows.solid()]
    return Fault(
        what="too few samples" if lines else "the file is empty",
        row=lines[-1] if lines else 1,
        got=("nothing", "a header only", "1 sample")[len(lines)],
        expected="a header and at least two samples",
        remedy="Export the log again; delete camera.csv if there was no camera.",
    )


def _convert(header: Header, rows: Rows, *, may_be_empty: bool) -> Table | None:
    """The table, None if there is a fault in it."""
    # In the place of numbers, None: the column has a cell that is none.
    parts: dict[int, list[Float64[np.ndarray, " some"]] | None]
    parts = {place: [] for place in (*header.columns, *header.extra)}
    for columns in _blocks(header, rows):
        if columns is None:
            return None
        for place, column in header.columns.items():
            empty = may_be_empty and column.name != "t"
            numbers = _numbers(columns[place], header.scale(place), may_be_empty=empty)
            if numbers is None or np.any(np.abs(numbers) > LARGEST):
                return None
            parts[place].append(numbers)
        for place in header.extra:
            numbers = None
            if parts[place] is not None:
                numbers = _numbers(columns[place], Scale(), may_be_empty=True)
            parts[place] = None if numbers is None else [*parts[place], numbers]
    values = {c.name: _joined(parts, place) for place, c in header.columns.items()}
    if len(values["t"]) < 2 or not np.all(np.diff(values["t"]) > 0):
        return None
    extra = {
        header.cells[place]: _texts(header, rows, place, len(values["t"]))
        if parts[place] is None
        else _joined(parts, place)
        for place in header.extra
    }
    return Table(values, {c.name: header.units[p] for p, c in header.columns.items()}, extra)


def _blocks(header: Header, rows: Rows) -> Iterator[Sequence[Sequence[str]] | None]:
    """The columns of some rows at a time; None where a row is of another length."""
    width, ended = len(header.cells), False
    try:
        for block in rows.blocks(width):
            blank = 0
            while blank < len(block) and not any(map(str.strip, block[-1 - blank])):
                blank += 1
            solid = block[: len(block) - blank]
            if solid and (ended or any(len(cells) != width for cells in solid)):
                yield None
                return
            ended = ended or blank > 0
            if solid:
                yield list(zip(*solid, strict=True))
    except csv.Error:
        yield None


def _joined(parts: dict[int, list | None], place: int) -> Float64[np.ndarray, " rows"]:
    """A column of its parts, which are let go of."""
    numbers, parts[place] = parts[place], []
    return np.concatenate([np.empty(0), *numbers])


def _texts(header: Header, rows: Rows, place: int, count: int) -> Shaped[np.ndarray, " rows"]:
    """A column that isn't one of numbers, as it is written."""
    # The longest cell's room for each would be too much.
    texts, done = np.empty(count, np.dtypes.StringDType()), 0
    for columns in _blocks(header, rows):
        texts[done : done + len(columns[place])] = columns[place]
        done += len(columns[place])
    return texts


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
