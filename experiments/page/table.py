"""A table as it is printed, whoever prints it."""

from typing import NamedTuple


class Table(NamedTuple):
    """A table of a report, its numbers as they are printed."""

    title: str
    """What it is about."""
    header: tuple[str, ...]
    """Names of the columns."""
    rows: tuple[tuple[str, ...], ...]
    """The lines."""
