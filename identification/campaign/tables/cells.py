"""The cells of a CSV file, one by one: the number in each, or what is wrong with it."""

import dataclasses
import math
import re
from collections.abc import Iterable, Iterator

from identification.campaign.faults import Fault
from identification.campaign.quantities import LARGEST
from identification.campaign.tables.columns import Scale
from identification.campaign.tables.header import Header
from identification.campaign.tables.rows import Row

_NUMBER = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+))(?:[eE]([+-]?\d{1,6}))?", re.ASCII)


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


def cell_faults(header: Header, body: Iterable[Row], *, may_be_empty: bool) -> Iterator[Fault]:
    """Everything that is wrong with the rows below a header, row by row.

    Args:
        header: The header.
        body: The rows below it.
        may_be_empty: Whether a cell other than time's may be empty.

    Yields:
        The faults.
    """
    before, time = "", -math.inf
    for line, cells in body:
        if len(cells) != len(header.cells):
            yield dataclasses.replace(_width(len(cells), len(header.cells)), row=line)
            continue
        for place, column in header.columns.items():
            text, fault = cells[place].strip(), None
            optional = may_be_empty and column.name != "t"
            value = cell_number(text, header.scale(place), may_be_empty=optional)
            if value is None or abs(value) > LARGEST:
                fault = _no_number(cells[place], optional=optional)
            elif column.name == "t":
                fault = None if value > time else _not_increasing(text, before)
                # Against the row before, so that one jump is one fault.
                before, time = text, value
            if fault is not None:
                yield dataclasses.replace(fault, row=line, column=header.cells[place])


def _width(width: int, expected: int) -> Fault:
    remedy = "Complete or delete the row; a log that was cut off ends in such a one."
    if width > expected:
        remedy = "Write decimals with a point, and no comma inside a cell or at the end."
    return Fault(
        what="a row of another length than the header",
        got=f"{width} cells",
        expected=f"{expected} cells",
        remedy=remedy,
    )


def _no_number(cell: str, *, optional: bool) -> Fault:
    what = "not a finite number" if _is_not_finite(cell) else "not a number"
    remedy = "Correct the cell, or delete the row; time may have gaps."
    if optional:
        remedy = "Leave the cell empty where the marker was lost."
    return Fault(
        what=what if cell.strip() else "an empty cell",
        got=repr(cell),
        expected="a finite decimal number",
        remedy=remedy,
    )


def _not_increasing(text: str, before: str) -> Fault:
    return Fault(
        what="time doesn't increase",
        got=f"{text} after {before}",
        expected="a later time in every row",
        remedy="Delete repeated rows; split the log where the clock was set back.",
    )


def _is_not_finite(text: str) -> bool:
    try:
        return not abs(float(text)) <= LARGEST
    except ValueError:
        return False
