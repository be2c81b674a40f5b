"""A text in columns as channels, each cell with its line."""

import itertools
import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Channel, Log
from identification.bring.files.csv.dialect import Dialect, is_missing, number
from identification.bring.files.csv.layout import Layout, Row, layout
from identification.bring.files.csv.text import Text, read_text
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
_CELLS = 2**16
"""Cells that are there at a time."""
_MOST = 2**25
"""Cells of a log, at the most: 256 MiB of numbers."""
_ODD = 2**20
"""Cells of a column that are no numbers, beyond which it is one of words."""


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
    fault = _too_many(path, found)
    if fault is not None:
        return None, (fault,)
    channels = _channels(found)
    if channels is None:
        return None, listed(_width_faults(found), file=str(path))
    return Log(path=path, channels=channels, notes=(_told(found, note),)), ()


def _too_many(path: Path, found: Layout) -> Fault | None:
    """More numbers than a gigabyte holds beside what is made of them."""
    count = found.count * len(found.header)
    if count <= _MOST:
        return None
    return Fault(
        what="more numbers than can be held",
        file=str(path),
        got=f"{found.count:,} rows of {len(found.header):,} columns",
        expected=f"{_MOST:,} cells at most",
        remedy="Export the columns that are needed alone, or cut the log into pieces.",
    )


def _width_faults(found: Layout) -> Iterator[Fault]:
    for line, cells in found.rows():
        if len(cells) != len(found.header):
            yield Fault(
                what="a row of another length than the header",
                row=line,
                got=f"{len(cells)} cells",
                expected=f"{len(found.header)} cells",
                remedy="Complete or delete the row; a log that was cut off ends in such a one.",
            )


def _channels(found: Layout) -> dict[str, Channel] | None:
    """The channels; None where a row is of another length than the header."""
    columns = [_Numbers() for _ in found.header]
    lines: list[np.ndarray] = []
    for rows in _blocks(found):
        if any(len(cells) != len(found.header) for _, cells in rows):
            return None
        lines.append(np.array([line for line, _ in rows]))
        for column, cells in zip(columns, zip(*(c for _, c in rows), strict=True), strict=True):
            column.take(cells, found.decimal)
    every_line = np.concatenate(lines)
    channels: dict[str, Channel] = {}
    for place, (header, unit) in enumerate(zip(found.header, found.units, strict=True)):
        column, columns[place] = columns[place], _Numbers()
        if not header and column.missing == len(every_line):
            continue  # a separator behind the last column
        name, count = header or f"column {len(channels) + 1}", 2
        while name in channels:
            name, count = f"{header} ({count})", count + 1
        is_text = 2 * len(column.odd) > len(every_line) or column.odd_is_full
        values = _texts(found, place) if is_text else np.concatenate(column.values)
        channels[name] = Channel(
            name=name,
            values=values,
            near=None if is_text else column.near,
            unit=unit or unit_in(header),
            odd={} if is_text else column.odd,
            lines=every_line,
        )
    return channels


def _blocks(found: Layout) -> Iterator[list[Row]]:
    rows, size = found.rows(), max(1, _CELLS // len(found.header))
    while block := list(itertools.islice(rows, size)):
        yield block


def _texts(found: Layout, place: int) -> np.ndarray:
    """A column as it is written."""
    # The longest cell's room for each would be too much.
    texts, done = np.empty(found.count, np.dtypes.StringDType()), 0
    for rows in _blocks(found):
        texts[done : done + len(rows)] = [cells[place] for _, cells in rows]
        done += len(rows)
    return texts


class _Numbers:
    """A column's numbers and the cells that are none, taken in block by block."""

    def __init__(self) -> None:
        self.values: list[np.ndarray] = []
        """Its numbers."""
        self.odd: dict[int, str] = {}
        """Cells that are no numbers, and don't say that there is none."""
        self.missing = 0
        """Cells that say that there is none."""
        self._count = 0
        self._base: int | None = None
        self._rest: list[np.ndarray] = []

    @property
    def odd_is_full(self) -> bool:
        """Whether there are more odd cells than are kept: a column of words."""
        return len(self.odd) >= _ODD

    @property
    def near(self) -> tuple[int, np.ndarray] | None:
        """Large numbers with digits that doubles haven't: stamps in seconds since 1970."""
        return None if self._base is None else (self._base, np.concatenate(self._rest))

    def take(self, cells: Sequence[str], decimal: str) -> None:
        """Take in some cells.

        Args:
            cells: The cells that follow.
            decimal: The decimal point.
        """
        values = _plain(cells, decimal)
        if values is None:
            values = np.full(len(cells), np.nan)
            for place, cell in enumerate(cells):
                value = number(cell, decimal)
                if value is not None:
                    values[place] = value
                elif is_missing(cell):
                    self.missing += 1
                elif not self.odd_is_full:
                    self.odd[self._count + place] = cell
        if not self._count and abs(values[0]) >= _LARGE:
            written = any(decimal in cell for cell in cells[:20])
            self._base = int(values[0]) if written else None
        if self._base is not None and np.isfinite(values).all():
            digits = (Decimal(cell.replace(decimal, ".")) for cell in cells)
            self._rest.append(np.array([float(each - self._base) for each in digits]))
        else:
            self._base = None
        self.values.append(values)
        self._count += len(cells)


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


def _plain(cells: Sequence[str], decimal: str) -> np.ndarray | None:
    """Numbers of cells, several times faster; None where one needs a closer look."""
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


def _told(found: Layout, encoding: str) -> str:
    parts = [f"columns between {_NAMES.get(found.separator, repr(found.separator))}"]
    if found.decimal == ",":
        parts.append("decimal commas")
    if any(found.units):
        parts.append("units in a row of their own")
    if not found.stated:
        parts.append("no header: columns by their number")
    if encoding:
        parts.append(encoding)
    if found.footer:
        parts.append(f"{found.footer} lines of words at the end left out")
    return ", ".join(parts)


def _no_columns(path: Path, text: Text) -> Fault:
    begin = " ".join(text.begin[:200].split())[:60]
    return Fault(
        what="no columns of numbers",
        file=str(path),
        got=repr(begin),
        expected="rows of as many numbers, between semicolons, commas, tabs, bars or blanks",
        remedy="State `separator`, `decimal` and `skip`, or export the log as CSV.",
    )
