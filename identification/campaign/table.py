"""A table of numbers in a CSV file: cells to SI units, every bad cell with its row.

A column is converted at once. Only where that fails, or time doesn't increase, is the
table gone through cell by cell, to find where.
"""

import csv
import dataclasses
import io
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.columns import Column, Header, Scale, read_header
from identification.campaign.faults import Fault, listed

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eE]([+-]?\d{1,6}))?", re.ASCII)


@dataclasses.dataclass(frozen=True, eq=False)
class Table:
    """A stream's columns."""

    values: dict[str, Float64[np.ndarray, " rows"]]
    """Every known column that is there, by name [SI]; NaN for an empty cell."""
    extra: dict[str, Shaped[np.ndarray, " rows"]]
    """The other columns by header: numbers if all its cells are, text otherwise."""


class _Row(NamedTuple):
    line: int
    """Line in the file."""
    cells: tuple[str, ...]


def read_table(
    path: Path, known: Sequence[Column], *, file: str, may_be_empty: bool
) -> tuple[Table | None, tuple[Fault, ...]]:
    """A stream's columns in SI units, and what is wrong with them.

    Args:
        path: The CSV file.
        known: The columns that the stream may have; the first is time.
        file: The file, relative to the campaign's folder.
        may_be_empty: Whether a cell other than time's may be empty.

    Returns:
        The table, None if there are faults; and the faults, at most about ten.
    """
    text, fault = read_text(path, file=file)
    if fault is not None:
        return None, (fault,)
    rows, broken = _rows(text, file)
    if not rows:
        return None, (broken or _empty(file),)
    header, faults = read_header(rows[0].cells, known, file=file)
    body = rows[1:]
    if len(body) < 2 and broken is None:
        return None, listed([*faults, _too_short(body, file)], file=file)
    if not header.names:  # another dialect: its rows would only repeat that
        return None, listed(faults, file=file)
    table = None if faults or broken else _bulk(header, body, may_be_empty=may_be_empty)
    if table is not None:
        return table, ()
    reader = _Careful(header, known[0].name, file, may_be_empty=may_be_empty)
    found = itertools.chain(faults, reader.faults(body), [broken] if broken else [])
    every = listed(found, file=file)
    return (None, every) if every else (reader.table(), ())


def read_text(path: Path, *, file: str) -> tuple[str, Fault | None]:
    """A file's text.

    Args:
        path: The file.
        file: The file, relative to the campaign's folder.

    Returns:
        The text, without a byte order mark; and the fault if there is none to be read.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return "", Fault(
            what="the file is missing",
            file=file,
            got="no such file",
            expected=f"the file {path.name}",
            remedy="Copy it there, or check its name.",
        )
    except OSError as error:
        return "", Fault(
            what="the file can't be read",
            file=file,
            got=f"{error.strerror}",
            expected="a readable text file",
            remedy="Check what it is and its permissions.",
        )
    binary = Fault(
        what="not text in UTF-8",
        file=file,
        row=content.count(b"\n") + 1,
        expected="a text file in UTF-8",
        remedy="Save it as plain text in UTF-8; a TDMS or MAT log goes through the importers.",
    )
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        got = f"the byte 0x{content[error.start]:02x}"
        return "", dataclasses.replace(binary, row=row, got=got)
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        return "", dataclasses.replace(binary, row=row, got="a zero byte")
    return text, None


def _rows(text: str, file: str) -> tuple[list[_Row], Fault | None]:
    """The rows without the blank ones at the end, and what ended the reading early."""
    reader = csv.reader(io.StringIO(text, newline=""))
    rows: list[_Row] = []
    broken = None
    try:
        rows.extend(_Row(reader.line_num, tuple(cells)) for cells in reader)
    except csv.Error as error:
        broken = Fault(
            what="the row can't be split into cells",
            file=file,
            row=reader.line_num,
            got=str(error),
            expected="cells separated by commas",
            remedy="Look for a lone quotation mark, or a damaged part of the file.",
        )
    while rows and not any(cell.strip() for cell in rows[-1].cells):
        rows.pop()
    return rows, broken


def _empty(file: str) -> Fault:
    return Fault(
        what="the file is empty",
        file=file,
        row=1,
        got="nothing",
        expected="a header and at least two samples",
        remedy="Export the log again; delete camera.csv if there was no camera.",
    )


def _too_short(body: list[_Row], file: str) -> Fault:
    return Fault(
        what="too few samples",
        file=file,
        row=body[-1].line if body else 1,
        got="1 sample" if body else "a header only",
        expected="at least two samples",
        remedy="Export the log again; delete camera.csv if there was no camera.",
    )


def _bulk(header: Header, body: list[_Row], *, may_be_empty: bool) -> Table | None:
    """The table if nothing is out of the ordinary."""
    width = len(header.cells)
    if any(len(row.cells) != width for row in body):
        return None
    columns = list(zip(*(row.cells for row in body), strict=True))
    values = {}
    for place, name in header.names.items():
        empty = may_be_empty and name != "t"
        numbers = _numbers(columns[place], header.scales[place], may_be_empty=empty)
        if numbers is None:
            return None
        values[name] = numbers
    if not np.all(np.diff(values["t"]) > 0):
        return None
    extra = {header.cells[place]: _extra(columns[place]) for place in header.extra}
    return Table(values, extra)


def _numbers(
    cells: Sequence[str], scale: Scale, *, may_be_empty: bool
) -> Float64[np.ndarray, " rows"] | None:
    """A column in SI units, None if a cell needs a closer look."""
    joined = "".join(cells)
    if "_" in joined or not joined.isascii():  # float() takes 1_000 and other scripts' digits
        return None
    # The unit's power of ten goes into the text: rounded once, and no "nan" passes.
    power = f"e{scale.exponent}"
    try:
        if may_be_empty:
            numbers = [float(cell + power) if cell else math.nan for cell in cells]
        else:
            numbers = [float(cell + power) for cell in cells]
    except ValueError:
        return None
    values = np.array(numbers, dtype=np.float64)
    return None if np.isinf(values).any() else values * scale.factor


def _extra(cells: Sequence[str]) -> Shaped[np.ndarray, " rows"]:
    numbers = _numbers(cells, Scale(), may_be_empty=True)
    return np.array(cells, dtype=str) if numbers is None else numbers


class _Careful:
    """Goes through a table cell by cell, in the order of its rows."""

    def __init__(self, header: Header, time: str, file: str, *, may_be_empty: bool):
        self._header = header
        self._file = file
        self._optional = {
            place: may_be_empty and name != time for place, name in header.names.items()
        }
        self._time = next((p for p, name in header.names.items() if name == time), None)
        self._values: dict[int, list[float]] = {place: [] for place in header.names}
        self._extra: dict[int, list[str]] = {place: [] for place in header.extra}
        self._last = (-math.inf, "")

    def faults(self, body: list[_Row]) -> Iterator[Fault]:
        """Everything that is wrong with the rows below the header, in their order."""
        for row in body:
            if len(row.cells) != len(self._header.cells):
                yield self._width(row)
                continue
            for place in self._header.names:
                yield from self._cell(row, place)
            for place, cells in self._extra.items():
                cells.append(row.cells[place])

    def table(self) -> Table:
        """The table, of rows without faults."""
        names, cells = self._header.names, self._header.cells
        return Table(
            {names[place]: np.array(column) for place, column in self._values.items()},
            {cells[place]: _extra(column) for place, column in self._extra.items()},
        )

    def _cell(self, row: _Row, place: int) -> Iterator[Fault]:
        text = row.cells[place].strip()
        value = _number(text, self._header.scales[place])
        if text == "" and self._optional[place]:
            value = math.nan
        elif value is None or not math.isfinite(value):
            yield self._no_number(row, place, text)
            return
        self._values[place].append(value)
        if place == self._time:
            if not value > self._last[0]:
                yield self._not_increasing(row, place, text)
            # Against the row before, so that one jump is one fault.
            self._last = (value, text)

    def _width(self, row: _Row) -> Fault:
        width = len(self._header.cells)
        remedy = "Complete or delete the row; a log that was cut off ends in such a one."
        if len(row.cells) > width:
            remedy = "Write decimals with a point, and no comma inside a cell or at the end."
        return Fault(
            what="a row of another length than the header",
            file=self._file,
            row=row.line,
            got=f"{len(row.cells)} cells",
            expected=f"{width} cells",
            remedy=remedy,
        )

    def _no_number(self, row: _Row, place: int, text: str) -> Fault:
        what = "not a number"
        remedy = "Correct the cell, or delete the row; time may have gaps."
        if text == "":
            what = "an empty cell"
        elif _is_not_finite(text):
            what = "not a finite number"
        if self._optional[place]:
            remedy = "Leave the cell empty where the marker was lost."
        return Fault(
            what=what,
            file=self._file,
            row=row.line,
            column=self._header.cells[place],
            got=repr(row.cells[place]),
            expected="a finite decimal number",
            remedy=remedy,
        )

    def _not_increasing(self, row: _Row, place: int, text: str) -> Fault:
        return Fault(
            what="time doesn't increase",
            file=self._file,
            row=row.line,
            column=self._header.cells[place],
            got=f"{text} after {self._last[1]}",
            expected="a later time in every row",
            remedy="Delete repeated rows; split the log where the clock was set back.",
        )


def _number(text: str, scale: Scale) -> float | None:
    match = _NUMBER.fullmatch(text)
    if match is None:
        return None
    exponent = int(match[2] or 0) + scale.exponent
    return float(f"{match[1]}e{exponent}") * scale.factor


def _is_not_finite(text: str) -> bool:
    try:
        return not math.isfinite(float(text))
    except ValueError:
        return False
