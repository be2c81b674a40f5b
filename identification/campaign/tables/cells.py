"""The cells of a CSV file, one by one: the number in each, or what is wrong with it."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from identification.campaign.faults import Fault
from identification.campaign.tables.columns import Scale
from identification.campaign.tables.header import Header

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eE]([+-]?\d{1,6}))?", re.ASCII)


class Row(NamedTuple):
    """A row of a CSV file."""

    line: int
    """Line in the file, from 1."""
    cells: tuple[str, ...]
    """Its cells as they are written."""


def cell_number(cell: str, scale: Scale, *, may_be_empty: bool) -> float | None:
    """The number in a cell.

    Args:
        cell: The cell as it is written.
        scale: Its column's unit.
        may_be_empty: Whether it may be empty.

    Returns:
        The number in SI units, NaN for an empty cell; None if it isn't a finite number.
    """
    text = cell.strip()
    if not text and may_be_empty:
        return math.nan
    match = _NUMBER.fullmatch(text)
    if match is None:
        return None
    number = float(f"{match[1]}e{int(match[2] or 0) + scale.exponent}") * scale.factor
    return number if math.isfinite(number) else None


class CellFaults:
    """The faults of a table, cell by cell in the order of its rows."""

    def __init__(self, header: Header, file: str, *, may_be_empty: bool):
        self._header = header
        self._file = file
        self._optional = {
            place: may_be_empty and name != "t" for place, name in header.names.items()
        }
        self._last = (-math.inf, "")

    def of(self, body: Sequence[Row]) -> Iterator[Fault]:
        """Everything that is wrong with the rows below the header."""
        for row in body:
            if len(row.cells) != len(self._header.cells):
                yield self._width(row)
                continue
            for place in self._header.names:
                yield from self._cell(row, place)

    def _cell(self, row: Row, place: int) -> Iterator[Fault]:
        text = row.cells[place].strip()
        scale, optional = self._header.scales[place], self._optional[place]
        value = cell_number(text, scale, may_be_empty=optional)
        if value is None:
            yield self._no_number(row, place, text)
        elif self._header.names[place] == "t":
            if not value > self._last[0]:
                yield self._not_increasing(row, place, text)
            # Against the row before, so that one jump is one fault.
            self._last = (value, text)

    def _width(self, row: Row) -> Fault:
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

    def _no_number(self, row: Row, place: int, text: str) -> Fault:
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

    def _not_increasing(self, row: Row, place: int, text: str) -> Fault:
        return Fault(
            what="time doesn't increase",
            file=self._file,
            row=row.line,
            column=self._header.cells[place],
            got=f"{text} after {self._last[1]}",
            expected="a later time in every row",
            remedy="Delete repeated rows; split the log where the clock was set back.",
        )


def _is_not_finite(text: str) -> bool:
    try:
        return not math.isfinite(float(text))
    except ValueError:
        return False
