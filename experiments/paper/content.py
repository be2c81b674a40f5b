"""What a section of the report is made of."""

from collections.abc import Callable
from typing import NamedTuple

from experiments.page.page import Picture, Pictures


class Table(NamedTuple):
    """A table of a section."""

    title: str
    """What it shows."""
    header: tuple[str, ...]
    """Names of its columns, units included."""
    rows: tuple[tuple[str, ...], ...]
    """Its cells."""


class Content(NamedTuple):
    """What a section says and shows."""

    sentences: tuple[str, ...]
    """What was found, a sentence each."""
    pictures: tuple[Picture, ...] = ()
    """Its figures."""
    tables: tuple[Table, ...] = ()
    """Its tables."""


class Section(NamedTuple):
    """A table, figure or question of the paper."""

    name: str
    """What it is called on the command line, "fig12"."""
    title: str
    """Its title."""
    seconds: float
    """How long it takes about, two cores and compiled functions at hand [s]."""
    build: Callable[[Pictures], Content]
    """What computes and draws it."""
