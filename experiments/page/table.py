"""A table as it is printed, whoever prints it."""

import dataclasses
from collections.abc import Iterable, Mapping


@dataclasses.dataclass(frozen=True)
class Table:
    """A table of a report or of the terminal, its numbers as they are printed."""

    title: str
    """What it is about; empty for none."""
    header: tuple[str, ...]
    """Names of the columns, units included."""
    rows: tuple[tuple[str, ...], ...]
    """The lines."""
    words: tuple[int, ...] = (0,)
    """Columns of words, which begin at the left; numbers end at the right."""
    spare: tuple[tuple[int, ...], ...] = ()
    """Columns that a narrow terminal can do without, in the order in which they go."""

    @property
    def untitled(self) -> "Table":
        """The same, where the title stands somewhere else."""
        return dataclasses.replace(self, title="")


def table_of(
    title: str,
    rows: Iterable[Mapping[str, str]],
    *,
    words: tuple[int, ...] = (0,),
    spare: tuple[tuple[str, ...], ...] = (),
) -> Table:
    """A table from lines that name their columns, so that no cell stands under another's name.

    Args:
        title: What it is about; empty for none.
        rows: The lines: texts by the columns' names, in the columns' order.
        words: Columns of words.
        spare: Names of columns that a narrow terminal can do without, in their order.

    Returns:
        The table; without lines it has no columns either.
    """
    lines = tuple(rows)
    header = tuple(lines[0]) if lines else ()
    without = tuple(
        tuple(header.index(name) for name in group if name in header) for group in spare
    )
    return Table(title, header, tuple(tuple(line.values()) for line in lines), words, without)
