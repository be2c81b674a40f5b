"""Discs through pictures of a video: what stays where it is, and what moves."""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.vision.proposal.patches import Disc, has_hue

_STILL = 2.0
_JUMP = 0.2
_ALIKE = 0.25
_MOSTLY = 0.5


@dataclasses.dataclass(frozen=True)
class Found:
    """A disc that is in most of the pictures."""

    colour: str
    """Name of its colour."""
    first: Disc
    """It where it was found first."""
    path: Float64[np.ndarray, "pictures 2"]
    """Where it is in each that it was found in [px]."""

    @property
    def moves(self) -> bool:
        """Whether it is a marker: marks stay where they are."""
        return bool(np.max(np.ptp(self.path, axis=0)) > _STILL)


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
            if len(trail) > _MOSTLY * len(discs):
                yield Found(name, trail[0], np.array([disc.centre for disc in trail]))


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
