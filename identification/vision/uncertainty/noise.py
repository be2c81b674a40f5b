"""What varies from picture to picture: noise of each marker, and what all have in common."""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.vision.poses import Poses
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies

_LEAST_NOISE = 0.01  # px: where a disc lies on the pixels costs that
_KEPT = 0.8  # share of the squares
_OF_KEPT = 0.4377  # mean square of a normal deviate's smaller four fifths
_OF_UNSURE = 0.18  # of the step from one order to the next, by rendered films
_OF_MISFIT = 0.65  # power, between none and proportional, by rendered films


@dataclasses.dataclass(frozen=True)
class Noise:
    """Standard deviations from picture to picture."""

    own: Float64[np.ndarray, "2 markers"]
    """Each marker's, along x and along y [m]."""
    common: float
    """That of all markers together, in each direction, as of a tripod's shaking [m]."""
    rows: Float64[np.ndarray, "2 markers"]
    """By rows that have another time than their picture [m]."""


def noise_of(
    vision: Vision,
    poses: Poses,
    size: Float64[np.ndarray, " markers"],
    misfit: Float64[np.ndarray, " markers"],
) -> Noise:
    """Noise of the markers, by what their bodies don't allow.

    Two markers beside each other tell by their distance how noisy they are along x, two
    carriages by their heights along y: by the difference what each has of its own, by the
    mean what they have in common. What tells a direction stands for all markers, as their
    discs' misfits are: partly, as noise of the pixels has its part in both. A distance shows
    errors that are opposite to each other, as of a plate's two edges in a fast picture, and
    that the body's middle doesn't have; so the geometric mean of both directions is taken
    where the distance says more than the heights.

    Args:
        vision: What is said of the video.
        poses: The poses.
        size: What a pixel is at each marker [m].
        misfit: How much the markers' discs are unlike their shape [1].

    Returns:
        Their noise.
    """
    share = (misfit / misfit.mean()) ** _OF_MISFIT
    heights = [
        poses.off_body[:, k]
        for body, members in of_bodies(vision)
        for k in members
        if body != "end_effector"
    ]
    scale = [
        (size * share)[k]
        for body, members in of_bodies(vision)
        for k in members
        if body != "end_effector"
    ]
    along_x = [_by_distance(vision, poses, size * share, members) for members in _rigid(vision)]
    along_y, common = _by_heights(heights, scale)
    told = [[x for x in along_x if np.isfinite(x)], [y for y in [along_y] if np.isfinite(y)]]
    usual = [
        float(np.sqrt(np.mean(np.square(way or [*told[0], *told[1], _LEAST_NOISE]))))
        for way in told
    ]
    usual[0] = min(usual[0], float(np.sqrt(usual[0] * usual[1])))
    own = np.maximum(np.array(usual)[:, None] * share, _LEAST_NOISE) * size
    return Noise(own, common, _of_rows(poses))


def _rigid(vision: Vision) -> Iterator[list[int]]:
    """Members of bodies with two markers or more that aren't above each other."""
    for body, members in of_bodies(vision):
        if body != "end_effector":
            continue
        own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
        wide = np.ptp(own, axis=0)
        if len(members) > 2 or wide[0] >= wide[1]:
            yield members


def _by_distance(
    vision: Vision, poses: Poses, scale: Float64[np.ndarray, " markers"], members: list[int]
) -> float:
    """Noise of a rigid body's markers [px]: of 2 n numbers three are the pose."""
    off = poses.off_body[:, members] / scale[members]
    left = (2 * len(members) - 3) / len(members)
    return float(np.sqrt(_trimmed(off[np.isfinite(off).all(axis=1)]) / left))


def _by_heights(
    heights: list[Float64[np.ndarray, " frames"]], scale: list[float]
) -> tuple[float, float]:
    """Noise of the carriages' markers of their own [px], and in common [m]."""
    if not heights:
        return float("nan"), 0.0
    if len(heights) == 1:
        return float(np.sqrt(_trimmed(heights[0]))) / scale[0], 0.0
    difference, mean = heights[0] - heights[1], (heights[0] + heights[1]) / 2
    own = _trimmed(difference)
    own = 0.0 if np.isnan(own) else own
    common = max(_trimmed(mean) - own / 4, 0.0)
    return float(np.sqrt(own / (scale[0] ** 2 + scale[1] ** 2))), float(np.sqrt(common))


def _of_rows(poses: Poses) -> Float64[np.ndarray, "2 markers"]:
    """What rows that have another time than the picture add, root mean square [m]."""
    used = np.where(np.isfinite(poses.places), poses.unsure, np.nan)
    count = np.maximum(np.isfinite(used).sum(axis=0), 1)
    return _OF_UNSURE * np.sqrt(np.nansum(used**2, axis=0) / count).T


def _trimmed(off: Float64[np.ndarray, "..."]) -> float:
    """Mean square by the smaller four fifths: some bad pictures tell nothing of the others."""
    square = np.sort((off[np.isfinite(off)] ** 2).ravel())
    kept = square[: max(1, int(np.ceil(_KEPT * len(square))))]
    return float(kept.mean() / _OF_KEPT) if len(kept) else float("nan")
