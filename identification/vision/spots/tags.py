"""ArUco tags: found by their number, their centre where the diagonals cross."""

import dataclasses
import functools
from typing import Any

import numpy as np
from jaxtyping import Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.spots.disc import Shape
from identification.vision.spots.look import Look, Picture, Sighting, Travel, piece

_QUIET = 4
_TIMES = 2
_CELLS = 7


@dataclasses.dataclass(frozen=True)
class Tag(Look):
    """A tag of a dictionary."""

    number: int
    """Its number."""
    dictionary: str
    """The dictionary's name, like "4X4_50"."""

    def at(
        self,
        picture: Picture,
        near: Float64[np.ndarray, " 2"],
        shape: Shape,
        reach: float,
        travel: Travel | None = None,
    ) -> Sighting | None:
        """The tag, in a piece of the picture about its place."""
        half = 2.5 * shape.radius + np.abs(shape.travel).max() + reach + _QUIET
        cut = piece(picture, near, half, least=8)
        if cut is None:
            return None
        low, patch = cut
        corners = detected(self.dictionary, np.ascontiguousarray(patch)).get(self.number)
        if corners is None:
            return None
        centre = crossing(corners)
        return Sighting(low + centre, 1.0, 0.0, 0.0)

    def places(
        self, picture: Picture, least: float, most: float
    ) -> list[Float64[np.ndarray, " 2"]]:
        """Where the tag is, if it is in the picture."""
        corners = detected(self.dictionary, picture).get(self.number)
        return [] if corners is None else [crossing(corners)]


def tag_size(dictionary: str, number: int, picture: Picture) -> float | None:
    """Radius of a circle that a tag would just fit in.

    Args:
        dictionary: The dictionary's name.
        number: The tag's number.
        picture: The picture.

    Returns:
        It [px]; None if the tag isn't seen.
    """
    corners = detected(dictionary, picture).get(number)
    if corners is None:
        return None
    return float(np.hypot(*(corners - corners.mean(axis=0)).T).mean())


def crossing(corners: Float64[np.ndarray, "4 2"]) -> Float64[np.ndarray, " 2"]:
    """Where the diagonals cross: perspective keeps lines, and means of corners it doesn't.

    Args:
        corners: A tag's corners in their order [px].

    Returns:
        Its centre [px].
    """
    first, second = corners[2] - corners[0], corners[3] - corners[1]
    along = np.linalg.solve(np.stack([first, -second], axis=-1), corners[1] - corners[0])
    return corners[0] + along[0] * first


def detected(dictionary: str, picture: Picture) -> dict[int, Float64[np.ndarray, "4 2"]]:
    """Corners of the tags in a picture, by their numbers.

    Tags are looked for in the picture twice as large, too: cells of four pixels are missed in
    one picture of three. Corners are found anew in the picture itself.

    Args:
        dictionary: The dictionary's name.
        picture: The picture.

    Returns:
        Corners of each [px].
    """
    cv2 = opencv()
    large = cv2.resize(picture, None, fx=_TIMES, fy=_TIMES, interpolation=cv2.INTER_CUBIC)
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    seen: dict[int, list[Float64[np.ndarray, "4 2"]]] = {}
    for image, times in ((large, _TIMES), (picture, 1)):
        corners, numbers, _ = _detector(dictionary).detectMarkers(image)
        here: dict[int, list[Float64[np.ndarray, "4 2"]]] = {}
        for number, each in zip(
            [] if numbers is None else np.ravel(numbers), corners, strict=False
        ):
            flat = (np.asarray(each, float).reshape(4, 2) + 0.5) / times - 0.5
            here.setdefault(int(number), []).append(flat)
        seen |= here
    # One number seen twice is none that can be relied on.
    return {number: _refined(grey, each[0]) for number, each in seen.items() if len(each) == 1}


def numbers_in(dictionary: str, picture: Picture) -> list[int]:
    """Numbers of the tags that are read at first sight.

    Args:
        dictionary: The dictionary's name.
        picture: The picture.

    Returns:
        They, each once.
    """
    _, numbers, _ = _detector(dictionary).detectMarkers(picture)
    return [] if numbers is None else sorted(set(np.ravel(numbers).tolist()))


def _refined(
    grey: UInt8[np.ndarray, "height width"], corners: Float64[np.ndarray, "4 2"]
) -> Float64[np.ndarray, "4 2"]:
    """Corners to a tenth of a pixel, within less than a cell."""
    cv2 = opencv()
    side = float(np.hypot(*(corners - np.roll(corners, 1, axis=0)).T).min())
    half = max(2, int(side / _CELLS / 2))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-3)
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    fine = cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria)
    return np.asarray(fine, float).reshape(4, 2)


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
    return aruco.ArucoDetector(aruco.getPredefinedDictionary(getattr(aruco, name)), settings)
