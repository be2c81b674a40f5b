"""A table as it is printed, whoever prints it."""

import dataclasses


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
