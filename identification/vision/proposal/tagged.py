"""ArUco tags through pictures of a video, of whichever dictionary they were printed from."""

import itertools
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from identification.vision.proposal.followed import MOSTLY, Found
from identification.vision.proposal.patches import Picture
from identification.vision.spots.tags import crossing, detected, numbers_in

_DICTIONARIES = (
    "4X4_50",
    "5X5_50",
    "6X6_50",
    "7X7_50",
    "ARUCO_ORIGINAL",
    "APRILTAG_36H11",
    "APRILTAG_16H5",
    "4X4_1000",
    "5X5_1000",
    "6X6_1000",
    "7X7_1000",
)
"""Dictionaries that are tried: a larger one of a kind has the smaller one's tags, too."""
_TRIED = 3
"""Pictures by which the dictionary is told."""
_FEWEST = 2
"""Tags that a rig with tags has at least; a plate with a disc is read as one now and then."""
_KEEPS = 0.02
"""Share of their distance by which two tags on one body may come nearer to each other."""
_NEAR = 1.5
"""Times the shortest distance: a third tag on the body."""

Corners = Float64[np.ndarray, "4 2"]


def tagged(shown: Sequence[Picture]) -> tuple[str, list[Found]]:
    """Tags that are seen in half of the pictures.

    Args:
        shown: Pictures from the whole of a video.

    Returns:
        Their dictionary, empty where there are none; and the tags with their paths.
    """
    few = [shown[k] for k in np.linspace(0, len(shown) - 1, _TRIED).astype(int)]
    counts = {name: _count([numbers_in(name, each) for each in few]) for name in _DICTIONARIES}
    dictionary = max(counts, key=lambda name: counts[name])
    if counts[dictionary] < _FEWEST:
        return "", []
    pictures = [detected(dictionary, picture) for picture in shown]
    numbers = sorted({number for seen in pictures for number in seen})
    often = [n for n in numbers if sum(n in seen for seen in pictures) > MOSTLY * len(shown)]
    found = [_found(number, [seen.get(number) for seen in pictures]) for number in often]
    return (dictionary if found else ""), found


def _count(seen: Sequence[list[int]]) -> int:
    """Tags that are in all of the pictures but one: clutter is read as a tag once."""
    numbers = [number for picture in seen for number in picture]
    return sum(numbers.count(number) >= len(seen) - 1 for number in set(numbers))


def _found(number: int, seen: Sequence[Corners | None]) -> Found:
    missing = np.full(2, np.nan)
    path = np.array([missing if corners is None else crossing(corners) for corners in seen])
    first = next(corners for corners in seen if corners is not None)
    across = first - first.mean(axis=0)
    return Found("", crossing(first), float(np.hypot(*across.T).mean()), path, aruco=number)


def together(markers: Sequence[Found]) -> list[bool]:
    """Which of the tags that move are on one body: the nearest that keep their distance.

    The carriages, one above the other, nearly keep theirs, which is as long as the frame is
    high.

    Args:
        markers: Marks that move.

    Returns:
        Of each, whether it is on that body.
    """
    pairs = {
        (a, b): _length(markers[a], markers[b])
        for a, b in itertools.combinations(range(len(markers)), 2)
    }
    kept = {pair: length for pair, length in pairs.items() if np.isfinite(length)}
    nearest = min(kept.values(), default=0.0)
    on_body = {k for pair, length in kept.items() if length < _NEAR * nearest for k in pair}
    return [k in on_body for k in range(len(markers))]


def _length(one: Found, other: Found) -> float:
    """The distance that two tags keep [px]; NaN where they don't."""
    if one.aruco is None or other.aruco is None:
        return float("nan")
    apart = one.path - other.path
    length = np.hypot(*apart[np.isfinite(apart).all(axis=1)].T)
    keep = len(length) > 1 and np.ptp(length) < _KEEPS * length.mean()
    return float(length.mean()) if keep else float("nan")
