"""Discs found by their colour, and then measured by their shape."""

import dataclasses
import math

import numpy as np
from jaxtyping import Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.settings.document import Colour
from identification.vision.spots.disc import Disc, Shape, measure, stored
from identification.vision.spots.look import (
    MOST_HIDDEN,
    Look,
    Picture,
    Sighting,
    Travel,
    piece,
)

_HUES = 256 / (2 * math.pi)
_MOST_STRETCHED = 2.5
_COARSE = 2
_FEW = 8
_NARROWER, _WIDER = -0.2, 0.8
_POOR = 0.06
_TRAVELS = (0.6, 1.0)
_OTHER_SIZE = 0.08


@dataclasses.dataclass(frozen=True)
class ColouredDisc(Look):
    """A disc of a colour."""

    colour: Colour
    """Its colour."""

    def at(
        self,
        picture: Picture,
        near: Float64[np.ndarray, " 2"],
        shape: Shape,
        reach: float,
        travel: Travel | None = None,
    ) -> Sighting | None:
        """The disc whose patch of colour is the nearest of those that are large enough."""
        half = np.sqrt((shape.axes**2).sum(axis=1)) + np.abs(shape.travel) / 2 + reach + 2
        cut = piece(picture, near, half, least=4)
        if cut is None:
            return None
        low, patch = cut
        area = math.pi * shape.radius**2
        mask = coloured(patch, self.colour)
        found = _patches(mask, 0.25 * area, math.inf)
        for inside in sorted(found, key=lambda each: float(np.hypot(*(low + each - near)))):
            if np.abs(low + inside - near).max() > reach + 0.5 * shape.radius:
                break
            moving = shape
            if travel is not None:
                moving = dataclasses.replace(shape, travel=travel(low + inside))
            seen = _measured(picture, low + inside, moving)
            if seen is None or seen.misfit > _POOR:
                # It may move otherwise than was thought.
                path = _path(mask, inside, shape)
                for share in () if path is None else _TRAVELS:
                    moving = dataclasses.replace(shape, travel=share * path)
                    other = _measured(picture, low + inside, moving)
                    if seen is None or (other is not None and other.misfit < seen.misfit):
                        seen = other
            if seen is not None:
                return seen
        return self._beneath(picture, near, shape)

    def _beneath(
        self, picture: Picture, near: Float64[np.ndarray, " 2"], shape: Shape
    ) -> Sighting | None:
        """The disc just where it is expected, its patch of colour being one with another's.

        An arm of like colour beside it makes one patch of both, whose middle is neither's.
        """
        disc = measure(picture, near, shape)
        if disc is None or disc.misfit > _POOR or disc.hidden > MOST_HIDDEN:
            return None
        if abs(disc.scale - 1) > _OTHER_SIZE:
            return None
        level = np.round(stored(disc.colour)).astype(np.uint8).reshape(1, 1, 3)
        if not coloured(level, self.colour).any():
            return None
        return _sighting(disc, shape)

    def places(
        self, picture: Picture, least: float, most: float
    ) -> list[Float64[np.ndarray, " 2"]]:
        """Centroids of patches of the colour that have about the area."""
        coarse = np.ascontiguousarray(picture[::_COARSE, ::_COARSE])
        scale = _COARSE**2
        found = _patches(coloured(coarse, self.colour), least / scale, most / scale)
        return [_COARSE * centre for centre in found]


def coloured(picture: Picture, colour: Colour) -> UInt8[np.ndarray, "height width"]:
    """Where a picture has a colour.

    Args:
        picture: The picture.
        colour: The colour.

    Returns:
        255 where it has, 0 elsewhere.
    """
    cv2 = opencv()
    tones = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL)
    low, high = (hue * _HUES for hue in colour.hue)
    rest_low = (255 * colour.saturation[0], 255 * colour.value[0])
    rest_high = (255 * colour.saturation[1], 255 * colour.value[1])
    if low <= high:
        return cv2.inRange(tones, (low, *rest_low), (high, *rest_high))
    upper = cv2.inRange(tones, (low, *rest_low), (255.0, *rest_high))
    return upper | cv2.inRange(tones, (0.0, *rest_low), (high, *rest_high))


def _patches(
    mask: UInt8[np.ndarray, "height width"], least: float, most: float
) -> list[Float64[np.ndarray, " 2"]]:
    _, _, stats, centres = opencv().connectedComponentsWithStats(mask)
    area, width, height = stats[1:, 4], stats[1:, 2], stats[1:, 3]
    stretched = np.maximum(width, height) > _MOST_STRETCHED * np.sqrt(area) + 20
    good = (area >= least) & (area <= most) & ~stretched
    return [np.asarray(centre, float) for centre in centres[1:][good]]


def _measured(
    picture: Picture, near: Float64[np.ndarray, " 2"], shape: Shape
) -> Sighting | None:
    disc = measure(picture, near, shape)
    return None if disc is None else _sighting(disc, shape)


def _sighting(disc: Disc, shape: Shape) -> Sighting:
    return Sighting(
        disc.centre, disc.scale, disc.hidden, disc.misfit, disc.variance, shape.travel
    )


def _path(
    mask: UInt8[np.ndarray, "height width"], inside: Float64[np.ndarray, " 2"], shape: Shape
) -> Float64[np.ndarray, " 2"] | None:
    r"""The path during the exposure by which a disc's patch of colour is longer than wide.

    An ellipse with axes $A$ has the second moments $A A^T / 4$, a path $d$ adds $d d^T / 12$.
    The blurred edge counts as the colour, which adds as much in all directions.
    """
    _, labels = opencv().connectedComponents(mask)
    row, column = np.round(inside[::-1]).astype(int)
    v, u = np.nonzero((labels == labels[row, column]) & (mask > 0))
    if len(u) < _FEW:
        return None
    usual = shape.axes @ shape.axes.T / 4
    values, vectors = np.linalg.eigh(np.cov(u, v) - usual)
    across = values[0] / (0.25 * shape.radius**2)
    if not _NARROWER < across < _WIDER:
        return None
    return np.sqrt(12 * (values[1] - values[0])) * vectors[:, 1]
