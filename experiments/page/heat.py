"""A table whose cells are coloured by what stands in them, and which needn't be cut."""

import dataclasses
from collections.abc import Sequence

from experiments.page.theme import contrast


@dataclasses.dataclass(frozen=True)
class Cell:
    """A cell: its text says what its colour says."""

    text: str
    """What stands in it."""
    fill: str = ""
    """Its colour, "#rrggbb"; empty for none."""
    strong: bool = False
    """Whether it is bold and framed."""

    @property
    def kind(self) -> str:
        """Its classes in the style sheet."""
        words = ("" if not self.fill else "ink" if _is_dark(self.fill) else "dark",)
        return " ".join(filter(None, (*words, "strong" if self.strong else "")))


@dataclasses.dataclass(frozen=True)
class Row:
    """A line."""

    name: str
    """What it is of."""
    cells: tuple[Cell, ...]
    """Its cells."""
    flagged: bool = False
    """Whether it is set apart."""


@dataclasses.dataclass(frozen=True)
class Heat:
    """The table."""

    caption: str
    """What to look at in it."""
    columns: tuple[str, ...]
    """Names of the columns."""
    rows: tuple[Row, ...]
    """The lines."""


def shade(share: float, colours: Sequence[str]) -> str:
    """A colour between others.

    Args:
        share: How far along they are, from 0 to 1; beyond that the nearest end.
        colours: Two at least, "#rrggbb".

    Returns:
        The colour.
    """
    place = min(max(share, 0.0), 1.0) * (len(colours) - 1)
    first = min(int(place), len(colours) - 2)
    part = place - first
    mixed = (
        round((1 - part) * low + part * high)
        for low, high in zip(_parts(colours[first]), _parts(colours[first + 1]), strict=True)
    )
    return "#" + "".join(f"{number:02x}" for number in mixed)


def _parts(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[place : place + 2], 16) for place in (1, 3, 5))


def _is_dark(colour: str) -> bool:
    """Whether white stands out on it more than black."""
    return contrast(colour, "#ffffff") > contrast(colour, "#000000")
