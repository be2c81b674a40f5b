"""What the report is made of: topics, their sections, and what these say and show."""

import dataclasses
from collections.abc import Callable

from experiments.page.page import Picture, Pictures
from experiments.page.table import Table
from experiments.paper.claim import Claim


@dataclasses.dataclass(frozen=True)
class Content:
    """What a section says and shows."""

    sentences: tuple[str, ...]
    """What was found, a sentence each."""
    pictures: tuple[Picture, ...] = ()
    """Its figures."""
    tables: tuple[Table, ...] = ()
    """Its tables."""


@dataclasses.dataclass(frozen=True)
class Section:
    """A table, figure or question of the paper."""

    name: str
    """What it is called on the command line, "fig12"."""
    title: str
    """Its title."""
    seconds: float
    """How long it takes about, two cores and compiled functions at hand [s]."""
    build: Callable[[Pictures], Content]
    """What computes and draws it."""


@dataclasses.dataclass(frozen=True)
class Topic:
    """Something that the paper is about."""

    sections: tuple[Section, ...]
    """Its sections of the report."""
    claims: tuple[Claim, ...] = ()
    """What is printed of it, and judged."""
