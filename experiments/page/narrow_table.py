"""A table in the columns that a terminal has.

A table that is too wide first breaks its headings and long cells between words; then it loses
the columns that it says are spare; then it goes on below in parts, each with its first column.
Cutting cells would be simpler, and half a number is a wrong one.
"""

import dataclasses
from collections.abc import Sequence

from experiments.page.table import Table
from experiments.page.wrapping import longest_word, wrapped

GAP = 2
"""Blanks between two columns."""
_SHORT = 16
"""Letters up to which a cell isn't broken even between its words."""


@dataclasses.dataclass(frozen=True)
class Cell:
    """A cell as it is printed."""

    text: str
    """What stands in it."""
    lines: tuple[str, ...]
    """The same in lines, each as wide as the column."""


@dataclasses.dataclass(frozen=True)
class Part:
    """Columns that fit beside each other."""

    header: tuple[Cell, ...]
    """Their names."""
    rows: tuple[tuple[Cell, ...], ...]
    """Their cells."""


@dataclasses.dataclass(frozen=True)
class NarrowTable:
    """A table as it is printed in so many columns."""

    parts: tuple[Part, ...]
    """What stands below each other."""
    left_out: tuple[str, ...]
    """Names of the columns for which there is no room."""


def narrowed(table: Table, width: int) -> NarrowTable:
    """A table in so many columns.

    Args:
        table: The table.
        width: Columns of the terminal.

    Returns:
        Its parts; a single column that is wider than the terminal stays whole.
    """
    kept, left_out = list(range(len(table.header))), []
    for group in table.spare:
        if _fits([_least(table, column) for column in kept], width):
            break
        kept = [column for column in kept if column not in group]
        left_out += [table.header[column] for column in group]
    parts = tuple(_part(table, columns, width) for columns in _beside(table, kept, width))
    return NarrowTable(parts, tuple(left_out))


def _beside(table: Table, columns: list[int], width: int) -> list[list[int]]:
    """Columns in groups that fit, the first column in each."""
    if not columns or _fits([_least(table, column) for column in columns], width):
        return [columns]
    first, *rest = columns
    groups, group = [], [first]
    for column in rest:
        longer = [_least(table, each) for each in (*group, column)]
        if len(group) > 1 and not _fits(longer, width):
            groups.append(group)
            group = [first]
        group.append(column)
    return [*groups, group]


def _part(table: Table, columns: Sequence[int], width: int) -> Part:
    widths = _widths(table, columns, width)
    left = [column in table.words for column in columns]
    header = [table.header[column] for column in columns]
    # Names stand at the bottom, beside what they name.
    names = [wrapped(name, room) for name, room in zip(header, widths, strict=True)]
    height = max(map(len, names), default=0)
    return Part(
        header=tuple(
            _cell(name, [*[""] * (height - len(lines)), *lines], room, side)
            for name, lines, room, side in zip(header, names, widths, left, strict=True)
        ),
        rows=tuple(
            tuple(
                _cell(row[column], wrapped(row[column], room), room, side)
                for column, room, side in zip(columns, widths, left, strict=True)
            )
            for row in table.rows
        ),
    )


def _cell(text: str, lines: Sequence[str], width: int, left: bool) -> Cell:
    return Cell(
        text, tuple(f"{line:<{width}}" if left else f"{line:>{width}}" for line in lines)
    )


def _widths(table: Table, columns: Sequence[int], width: int) -> list[int]:
    """Room for each column: what it takes, the widest narrowed first."""
    room = [max(map(len, _texts(table, column))) for column in columns]
    least = [_least(table, column) for column in columns]
    while not _fits(room, width):
        # What can give way, and of it the widest.
        wide = [at for at in range(len(room)) if room[at] > least[at]]
        if not wide:
            break
        room[max(wide, key=room.__getitem__)] -= 1
    return room


def _least(table: Table, column: int) -> int:
    """Room that a column can't do without."""
    name, *cells = _texts(table, column)
    needs = [longest_word(name)]
    needs += [len(c) if len(c) <= _SHORT else max(longest_word(c), _SHORT) for c in cells]
    return max(needs)


def _texts(table: Table, column: int) -> list[str]:
    return [table.header[column], *(row[column] for row in table.rows)]


def _fits(widths: Sequence[int], width: int) -> bool:
    return sum(widths) + GAP * (len(widths) - 1) <= width
