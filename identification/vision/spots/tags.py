"""ArUco tags: found by their number, their centre where the diagonals cross."""

import dataclasses
import functools
from typing import Any

import numpy as np
from jaxtyping import Float64

from identification.vision.pictures.opencv import opencv
from identification.vision.spots.disc import Shape
from identification.vision.spots.look import Look, Picture, Sighting

_QUIET = 4
_TIMES = 2


@dataclasses.dataclass(frozen=True)
class Tag(Look):
    """A tag of a dictionary."""

    number: int
    """Its number."""
    dictionary: str
    """The dictionary's name, like "4X4_50"."""

    def at(
        self, picture: Picture, near: Float64[np.ndarray, " 2"], shape: Shape, reach: float
    ) -> Sighting | None:
        """The tag, in a piece of the picture about its place."""
        half = 2.5 * shape.radius + np.abs(shape.travel).max() + reach + _QUIET
        low = np.maximum(np.floor(near - half), 0).astype(int)
        high = np.minimum(np.ceil(near + half) + 1, picture.shape[1::-1]).astype(int)
        if (high - low < 8).any():
            return None
        cv2 = opencv()
        patch = np.ascontiguousarray(picture[low[1] : high[1], low[0] : high[0]])
        # Cells of three pixels are missed in one picture of three, of six in none.
        large = cv2.resize(patch, None, fx=_TIMES, fy=_TIMES, interpolation=cv2.INTER_CUBIC)
        corners = _detected(self.dictionary, large).get(self.number)
        if corners is None:
            return None
        centre = (_crossing(corners) + 0.5) / _TIMES - 0.5
        return Sighting(low + centre, 1.0, 0.0, 0.0)

    def places(
        self, picture: Picture, least: float, most: float
    ) -> list[Float64[np.ndarray, " 2"]]:
        """Where the tag is, if it is in the picture."""
        corners = _in_whole(self.dictionary, picture).get(self.number)
        return [] if corners is None else [_crossing(corners)]


def tag_size(dictionary: str, number: int, picture: Picture) -> float | None:
    """Radius of a circle that a tag would just fit in.

    Args:
        dictionary: The dictionary's name.
        number: The tag's number.
        picture: The picture.

    Returns:
        It [px]; None if the tag isn't seen.
    """
    corners = _in_whole(dictionary, picture).get(number)
    if corners is None:
        return None
    return float(np.hypot(*(corners - corners.mean(axis=0)).T).mean())


def _crossing(corners: Float64[np.ndarray, "4 2"]) -> Float64[np.ndarray, " 2"]:
    """Where the diagonals cross: perspective keeps lines, and means of corners it doesn't."""
    first, second = corners[2] - corners[0], corners[3] - corners[1]
    along = np.linalg.solve(np.stack([first, -second], axis=-1), corners[1] - corners[0])
    return corners[0] + along[0] * first


def _in_whole(dictionary: str, picture: Picture) -> dict[int, Float64[np.ndarray, "4 2"]]:
    """Tags of a whole picture."""
    cv2 = opencv()
    large = cv2.resize(picture, None, fx=_TIMES, fy=_TIMES, interpolation=cv2.INTER_CUBIC)
    found = _detected(dictionary, large)
    return {number: (corners + 0.5) / _TIMES - 0.5 for number, corners in found.items()}


def _detected(dictionary: str, picture: Picture) -> dict[int, Float64[np.ndarray, "4 2"]]:
    corners, numbers, _ = _detector(dictionary).detectMarkers(picture)
    if numbers is None:
        return {}
    flat = np.ravel(numbers).tolist()
    # One number seen twice is none that can be relied on.
    return {
        number: np.asarray(each, float).reshape(4, 2)
        for number, each in zip(flat, corners, strict=True)
        if flat.count(number) == 1
    }


@functools.cache
def _detector(dictionary: str) -> Any:
    aruco = opencv().aruco
    name = f"DICT_{dictionary}"
    names = [each for each in dir(aruco) if each.startswith("DICT_")]
    if name not in names:
        known = sorted(each.removeprefix("DICT_") for each in names)
        raise ValueError(
            f"dictionary: no dictionary of tags, got {dictionary!r}, expected one of "
            f"{', '.join(known)}. Say the one that the tags were printed from."
        )
    settings = aruco.DetectorParameters()
    settings.cornerRefinementMethod = aruco.CORNER_REFINE_SUBPIX
    return aruco.ArucoDetector(aruco.getPredefinedDictionary(getattr(aruco, name)), settings)
