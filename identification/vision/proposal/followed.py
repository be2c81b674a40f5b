"""Discs through pictures of a video: what stays where it is, and what moves."""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.vision.proposal.patches import Disc, has_hue

_STILL = 2.0
_JUMP = 0.2
_ALIKE = 0.25
MOSTLY = 0.5
"""Share of the pictures in which a mark or marker is seen."""


@dataclasses.dataclass(frozen=True)
class Found:
    """A disc or a tag that is in most of the pictures."""

    colour: str
    """Name of its colour; empty of a tag."""
    centre: Float64[np.ndarray, " 2"]
    """Where it was found first [px]."""
    radius: float
    """Its radius there; of a tag half its diagonal [px]."""
    path: Float64[np.ndarray, "pictures 2"]
    """Where it is; of a tag in each picture, NaN where it isn't found [px]."""
    aruco: int | None = None
    """Its number if it is a tag."""

    @property
    def moves(self) -> bool:
        """Whether it is a marker: marks stay where they are."""
        lowest, highest = np.nanmin(self.path, axis=0), np.nanmax(self.path, axis=0)
        return bool((highest - lowest).max() > _STILL)


def followed(
    discs: list[list[Disc]], colours: dict[str, tuple[float, float]], size: int
) -> Iterator[Found]:
    """Discs that are seen in half of the pictures.

    Args:
        discs: Discs of each picture.
        colours: Lowest and highest hue of each colour [deg].
        size: Longer side of a picture [px].

    Yields:
        Each with its path.
    """
    for name, colour in colours.items():
        trails: list[list[Disc]] = []
        for each in discs:
            _lengthen(trails, [d for d in each if has_hue(colour, d.hue)], _JUMP * size)
        for trail in trails:
            if len(trail) > MOSTLY * len(discs):
                path = np.array([disc.centre for disc in trail])
                yield Found(name, path[0], trail[0].radius, path)


def _lengthen(trails: list[list[Disc]], discs: list[Disc], reach: float) -> None:
    """Put a picture's discs at the ends of trails, the nearest first; the rest begin some."""
    pairs = sorted(
        (float(np.hypot(*(disc.centre - trail[-1].centre))), a, b)
        for a, trail in enumerate(trails)
        for b, disc in enumerate(discs)
        if abs(disc.radius / trail[-1].radius - 1) < _ALIKE
    )
    longer: set[int] = set()
    taken: set[int] = set()
    for distance, a, b in pairs:
        if distance < reach and a not in longer and b not in taken:
            trails[a].append(discs[b])
            longer.add(a)
            taken.add(b)
    trails += [[disc] for b, disc in enumerate(discs) if b not in taken]
