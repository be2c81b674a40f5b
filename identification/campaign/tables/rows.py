"""The rows of a CSV file, a few at a time.

A table of 64 MiB has ten million cells, and each would take 60 bytes as a text of its own: a
gigabyte, for numbers of a tenth of it. So rows are split from the file's bytes whenever they
are gone through, and only some of them are there at a time.
"""

import csv
import dataclasses
import functools
import io
import itertools
from collections.abc import Iterator, Sequence

from identification.campaign.faults import Fault

Row = tuple[int, Sequence[str]]
"""A row of a CSV file: its line, from 1, and its cells as they are written."""
_CELLS = 2**16
"""Cells that are there at a time."""


@dataclasses.dataclass(frozen=True, eq=False)
class Rows:
    """The rows of a text in UTF-8."""

    content: bytes
    """The text."""

    @property
    def first(self) -> Sequence[str]:
        """Cells of the first row; none where there is no such row."""
        try:
            return next(self._reader(), [])
        except csv.Error:
            return []

    def blocks(self, width: int) -> Iterator[list[list[str]]]:
        """Rows below the first one, some at a time.

        Args:
            width: Cells that a row usually has.

        Yields:
            The cells of some rows.

        Raises:
            csv.Error: If a row can't be split into cells.
        """
        reader = self._reader()
        next(reader, None)
        size = max(1, _CELLS // max(width, 1))
        while block := list(itertools.islice(reader, size)):
            yield block

    def solid(self) -> Iterator[Row]:
        """The rows with their lines, without the blank ones at the end."""
        count, _ = self.extent
        reader = self._reader()
        for cells in itertools.islice(reader, count):
            yield reader.line_num, cells

    @functools.cached_property
    def extent(self) -> tuple[int, Fault | None]:
        """Number of rows without the blank ones at the end; what ended the reading early."""
        reader = self._reader()
        count = 0
        try:
            for number, cells in enumerate(reader, start=1):
                if any(cell.strip() for cell in cells):
                    count = number
        except csv.Error as error:
            return count, Fault(
                what="the row can't be split into cells",
                row=reader.line_num,
                got=str(error),
                expected="cells separated by commas",
                remedy="Look for a lone quotation mark, or a damaged part of the file.",
            )
        return count, None

    def _reader(self) -> "csv._reader":
        lines = io.TextIOWrapper(io.BytesIO(self.content), "utf-8-sig", newline="")
        return csv.reader(lines)
