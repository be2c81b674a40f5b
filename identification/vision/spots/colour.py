"""Discs found by their colour, and then measured by their shape."""

import dataclasses
import math

import numpy as np
from jaxtyping import Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.settings.document import Colour
from identification.vision.spots.disc import Shape, measure
from identification.vision.spots.look import Look, Picture, Sighting

_HUES = 256 / (2 * math.pi)
_MOST_STRETCHED = 2.5
_COARSE = 2


@dataclasses.dataclass(frozen=True)
class ColouredDisc(Look):
    """A disc of a colour."""

    colour: Colour
    """Its colour."""

    def at(
        self, picture: Picture, near: Float64[np.ndarray, " 2"], shape: Shape, reach: float
    ) -> Sighting | None:
        """The disc whose patch of colour is the nearest of those that are large enough."""
        half = np.sqrt((shape.axes**2).sum(axis=1)) + np.abs(shape.travel) / 2 + reach + 2
        low = np.maximum(np.floor(near - half), 0).astype(int)
        high = np.minimum(np.ceil(near + half) + 1, picture.shape[1::-1]).astype(int)
        if (high - low < 4).any():
            return None
        patch = picture[low[1] : high[1], low[0] : high[0]]
        area = math.pi * shape.radius**2
        found = _patches(coloured(patch, self.colour), 0.25 * area, math.inf)
        for centre in sorted((low + each for each in found), key=_distance_to(near)):
            if np.abs(centre - near).max() > reach + 0.5 * shape.radius:
                break
            disc = measure(picture, centre, shape)
            if disc is not None:
                return Sighting(disc.centre, disc.scale, disc.hidden, disc.misfit)
        return None

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


def _distance_to(near: Float64[np.ndarray, " 2"]):
    return lambda centre: float(np.hypot(*(centre - near)))
