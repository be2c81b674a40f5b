"""What the report is made of: sections, and what these say, show and claim."""

import dataclasses
from collections.abc import Callable

from experiments.page.page import Picture, Pictures
from experiments.page.table import Table
from experiments.paper.claim import Claim


class Content:
    """What a section says and shows."""

    def __init__(self, *parts: str | Picture | Table) -> None:
        """Take the parts, each kind in the order in which the page has it.

        Args:
            parts: What was found, a sentence each; figures; tables.
        """
        self.sentences = tuple(part for part in parts if isinstance(part, str))
        self.pictures = tuple(part for part in parts if isinstance(part, Picture))
        self.tables = tuple(part for part in parts if isinstance(part, Table))


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
    claims: tuple[Claim, ...] = ()
    """What is printed of it, and judged; in the paper's order."""
