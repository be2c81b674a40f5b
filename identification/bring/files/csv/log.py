"""A text in columns as channels, each cell with its line."""

import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Channel, Log
from identification.bring.files.csv.dialect import (
    Dialect,
    Layout,
    is_missing,
    layout,
    number,
)
from identification.bring.files.csv.text import read_text
from identification.campaign.faults import Fault, listed
from identification.campaign.quantities import LARGEST

_UNIT = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\)|<(?P<angle>[^<>]*)>)"
)
_NAMES = {";": "semicolons", "\t": "tabs", ",": "commas", "|": "bars", " ": "blanks"}
_HEADER = 200
"""Characters of a header's cell that are looked at for a unit; a longer one has none."""
_LARGE = 1e8
"""Numbers from which on a double rounds the eighth digit behind the point."""


def read_csv(path: Path, dialect: Dialect) -> tuple[Log | None, tuple[Fault, ...]]:
    """The channels of a text in columns.

    Args:
        path: The file.
        dialect: What is known of how it is written.

    Returns:
        The log, None if there are faults; and the faults.
    """
    text, note, fault = read_text(path, dialect.encoding)
    if fault is not None:
        return None, (fault,)
    found = layout(text, dialect)
    if found is None:
        return None, (_no_columns(path, text),)
    rows, footer = _without_footer(found)
    faults = listed(_width_faults(found, rows), file=str(path))
    if faults:
        return None, faults
    notes = (_told(found, note, footer),)
    return Log(path=path, channels=_channels(found, rows), notes=notes), ()


def _without_footer(found: Layout) -> tuple[list[tuple[int, tuple[str, ...]]], int]:
    """The rows without lines of words at the end, and how many these are."""
    rows = list(found.rows)
    count = 0
    while rows and not any(number(cell, found.decimal) is not None for cell in rows[-1][1]):
        rows.pop()
        count += 1
    return rows, count


def _width_faults(
    found: Layout, rows: Sequence[tuple[int, tuple[str, ...]]]
) -> Iterator[Fault]:
    for line, cells in rows:
        if len(cells) != len(found.header):
            yield Fault(
                what="a row of another length than the header",
                row=line,
                got=f"{len(cells)} cells",
                expected=f"{len(found.header)} cells",
                remedy="Complete or delete the row; a log that was cut off ends in such a one.",
            )


def _channels(found: Layout, rows: Sequence[tuple[int, tuple[str, ...]]]) -> dict[str, Channel]:
    lines = np.array([line for line, _ in rows])
    columns = list(zip(*(cells for _, cells in rows), strict=True))
    channels: dict[str, Channel] = {}
    for header, unit, cells in zip(found.header, found.units, columns, strict=True):
        if not header and all(map(is_missing, cells)):
            continue  # a separator behind the last column
        name, count = header or f"column {len(channels) + 1}", 2
        while name in channels:
            name, count = f"{header} ({count})", count + 1
        values, odd = _numbers(cells, found.decimal)
        channels[name] = Channel(
            name=name,
            values=values,
            near=_near(cells, values, found.decimal),
            unit=unit or unit_in(header),
            odd=odd,
            lines=lines,
        )
    return channels


def unit_in(header: str) -> str:
    """The unit in a header's cell, `X (mm)` or `t [s]`.

    Args:
        header: The cell.

    Returns:
        The unit, empty where there is none.
    """
    match = _UNIT.fullmatch(header.strip()[:_HEADER])
    if match is None:
        return ""
    return next(g for g in match.group("square", "round", "angle") if g is not None).strip()


def bare(header: str) -> str:
    """A header's cell without its unit.

    Args:
        header: The cell.

    Returns:
        The name alone.
    """
    match = _UNIT.fullmatch(header.strip()[:_HEADER])
    return header.strip() if match is None else match["name"].strip()


def _numbers(cells: Sequence[str], decimal: str) -> tuple[np.ndarray, dict[int, str]]:
    """A column's numbers and the cells that are none; texts where most are none."""
    quick = _plain(cells, decimal)
    if quick is not None:
        return quick, {}
    values = np.full(len(cells), np.nan)
    odd: dict[int, str] = {}
    for place, cell in enumerate(cells):
        value = number(cell, decimal)
        if value is not None:
            values[place] = value
        elif not is_missing(cell):
            odd[place] = cell
    if 2 * len(odd) > len(cells):
        return np.array(cells, dtype=str), {}
    return values, odd


def _plain(cells: Sequence[str], decimal: str) -> np.ndarray | None:
    """The same, several times faster; None where a cell needs a closer look."""
    joined = "".join(cells)
    if not joined.isascii() or any(mark in joined for mark in "_nNdD '"):
        return None
    if decimal == ",":
        if "." in joined:
            return None
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        values = np.array([float(cell) for cell in cells])
    except ValueError:
        return None
    return values if np.all(np.abs(values) <= LARGEST) else None


def _near(
    cells: Sequence[str], values: np.ndarray, decimal: str
) -> tuple[int, np.ndarray] | None:
    """Large numbers with digits that doubles haven't: stamps in seconds since 1970."""
    if values.dtype.kind != "f" or not np.isfinite(values).all() or abs(values[0]) < _LARGE:
        return None
    if not any(decimal in cell for cell in cells[:20]):
        return None
    base = int(values[0])
    rest = [float(Decimal(cell.replace(decimal, ".")) - base) for cell in cells]
    return base, np.array(rest)


def _told(found: Layout, encoding: str, footer: int) -> str:
    parts = [f"columns between {_NAMES.get(found.separator, repr(found.separator))}"]
    if found.decimal == ",":
        parts.append("decimal commas")
    if any(found.units):
        parts.append("units in a row of their own")
    if not found.stated:
        parts.append("no header: columns by their number")
    if encoding:
        parts.append(encoding)
    if footer:
        parts.append(f"{footer} lines of words at the end left out")
    return ", ".join(parts)


def _no_columns(path: Path, text: str) -> Fault:
    begin = " ".join(text[:200].split())[:60]
    return Fault(
        what="no columns of numbers",
        file=str(path),
        got=repr(begin),
        expected="rows of as many numbers, between semicolons, commas, tabs, bars or blanks",
        remedy="State `separator`, `decimal` and `skip`, or export the log as CSV.",
    )
