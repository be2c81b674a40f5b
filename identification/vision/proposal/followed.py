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
    """It in the first picture."""
    path: Float64[np.ndarray, "pictures 2"]
    """Where it is in each that it was found in [px]."""

    @property
    def moves(self) -> bool:
        """Whether it is a marker: marks stay where they are."""
        return bool(np.nanmax(np.ptp(self.path, axis=0)) > _STILL)


def followed(
    discs: list[list[Disc]], colours: dict[str, tuple[float, float]], size: int
) -> Iterator[Found]:
    """Discs of the first picture that are seen in half of the others, too.

    Args:
        discs: Discs of each picture.
        colours: Lowest and highest hue of each colour [deg].
        size: Longer side of a picture [px].

    Yields:
        Each with its path.
    """
    for name, colour in colours.items():
        own = [[disc for disc in each if has_hue(colour, disc.hue)] for each in discs]
        for first in own[0]:
            path, at = [first.centre], first.centre
            for others in own[1:]:
                near = [
                    d
                    for d in others
                    if np.hypot(*(d.centre - at)) < _JUMP * size
                    and abs(d.radius / first.radius - 1) < _ALIKE
                ]
                best = min(near, key=lambda d: float(np.hypot(*(d.centre - at))), default=None)
                if best is not None:
                    at = best.centre
                path.append(np.full(2, np.nan) if best is None else at)
            seen = np.isfinite(np.array(path)[:, 0])
            if seen.mean() > _MOSTLY:
                yield Found(name, first, np.array(path)[seen])
