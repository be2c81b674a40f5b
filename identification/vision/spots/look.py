"""What a mark or marker looks like, and how it is found: a disc, or a tag."""

import abc
import dataclasses
from collections.abc import Callable

import numpy as np
from jaxtyping import Float64, Int, UInt8

from identification.vision.spots.disc import Shape

Picture = UInt8[np.ndarray, "height width 3"]
Travel = Callable[[Float64[np.ndarray, " 2"]], Float64[np.ndarray, " 2"]]
"""Path during the exposure of what is seen at a place [px]."""

MOST_HIDDEN = 0.02
"""Share of a disc that may be another colour for it to count as whole [1]."""


@dataclasses.dataclass(frozen=True)
class Sighting:
    """A mark or marker as it was seen."""

    centre: Float64[np.ndarray, " 2"]
    """Centroid of a disc's picture, centre of a tag's [px]."""
    scale: float
    """Size over the one that was expected [1]."""
    hidden: float
    """Share of it that is covered [1]."""
    misfit: float
    """How much it is unlike its shape [1]."""
    variance: Float64[np.ndarray, " 2"] = dataclasses.field(
        default_factory=lambda: np.full(2, np.nan)
    )
    """Of its centre's coordinates by its own picture; NaN where that doesn't tell [px²]."""
    travel: Float64[np.ndarray, " 2"] = dataclasses.field(default_factory=lambda: np.zeros(2))
    """Path during the exposure that it was taken to have [px]."""

    @property
    def is_whole(self) -> bool:
        """Whether nothing is before it."""
        return self.hidden < MOST_HIDDEN


class Look(abc.ABC):
    """What a mark or marker looks like."""

    @abc.abstractmethod
    def at(
        self,
        picture: Picture,
        near: Float64[np.ndarray, " 2"],
        shape: Shape,
        reach: float,
        travel: Travel | None = None,
    ) -> Sighting | None:
        """Find it where it is expected.

        Args:
            picture: The picture.
            near: Where it is expected [px].
            shape: Its shape there.
            reach: How far from there it may be [px].
            travel: Its path, where that depends on its place; the shape's if not stated.

        Returns:
            It, if it is there.
        """

    @abc.abstractmethod
    def places(
        self, picture: Picture, least: float, most: float
    ) -> list[Float64[np.ndarray, " 2"]]:
        """Everywhere in a picture where it might be.

        Args:
            picture: The picture.
            least: Least area [px²].
            most: Most area [px²].

        Returns:
            Places, to a few pixels [px].
        """


def piece(
    picture: Picture,
    near: Float64[np.ndarray, " 2"],
    half: Float64[np.ndarray, " 2"] | float,
    least: int,
) -> tuple[Int[np.ndarray, " 2"], UInt8[np.ndarray, "rows columns 3"]] | None:
    """A piece of a picture about a place, as far as the picture goes.

    Args:
        picture: The picture.
        near: The place [px].
        half: How far the piece goes from there [px].
        least: Least width and height [px].

    Returns:
        Its first column and row, and the piece; None of one that is too small.
    """
    low = np.maximum(np.floor(near - half), 0).astype(int)
    high = np.minimum(np.ceil(near + half) + 1, picture.shape[1::-1]).astype(int)
    if (high - low < least).any():
        return None
    return low, picture[low[1] : high[1], low[0] : high[0]]
