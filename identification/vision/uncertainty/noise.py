r"""What varies from picture to picture: noise of each marker, and what all have in common.

Each disc's picture tells how far its place may be off (`spots.disc`), by direction: a fast
disc is blurred along its way, a dark one has less light. It does within a fifth, and a third
too little where a codec has smoothed away what it is off by. What the bodies don't allow tells
the rest: a rigid body's markers keep their distances and a carriage its height, so what these
do is error. Neither alone would do: no carriage says how far it is off along its guide, and no
disc what its codec did to it.

What changes slowly along the guides is the lens's and the plane's, which are told elsewhere,
so a parabola in the place is taken off first.
"""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import View
from identification.vision.poses import Poses
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.uncertainty.columns import columns_of

_LEAST_NOISE = 0.01  # px: where a disc lies on the pixels costs that
_UNKNOWN = 0.1  # px: of a tag, before its body is asked
_KEPT = 0.95  # share of the squares
_OF_KEPT = 0.7588  # mean square of a normal deviate's smaller 95 %
_OF_UNSURE = 0.18  # of the step from one order to the next, by rendered films
_STANDS_OUT, _OF_KINK = 6.0, 0.8  # of the median; of the step
_LEAST_RATIO = 1e-2
_CODED = 1.16  # a codec smooths away what discs, marks, heights and distances would show
_BELIEVED = 0.6  # share of a body's word: it scatters, too, and discs alone are within a fifth
_ORDER, _FRAMES = (
    2,
    6,
)  # of the polynomial that is taken off, and pictures for each of its terms


@dataclasses.dataclass(frozen=True)
class Noise:
    """Standard deviations from picture to picture."""

    own: Float64[np.ndarray, "2 markers"]
    """Each marker's, along x and along y [m]."""
    shake: Float64[np.ndarray, "2 markers"]
    """What the shift at each marker's row is off by, along x and along y, and so it is [m]."""
    rows: dict[str, float]
    """Each column's, by rows that have another time than their picture [m, rad]."""


def noise_of(
    vision: Vision,
    view: View,
    poses: Poses,
    variance: Float64[np.ndarray, "frames markers 2"],
    shake: Float64[np.ndarray, "2 markers"],
) -> Noise:
    """Noise of the markers.

    Args:
        vision: What is said of the video.
        view: Where the camera stands.
        poses: The poses.
        variance: Of each marker's coordinates in each picture, by its disc; NaN where that
            doesn't tell [px²].
        shake: How far the shift at each marker's row is off along each direction [px].

    Returns:
        Their noise.
    """
    expected = _expected(vision, view, poses, variance)
    rigid = np.mean(list(_of_rigid(vision, poses, expected)) or [np.nan])
    shaken = _of_shake(vision, view, poses, shake)
    guided = np.mean(list(_of_guided(vision, poses, expected, shaken[1] ** 2)) or [np.nan])
    own = expected.copy()
    for k, marker in enumerate(vision.markers):
        words = (rigid, guided) if marker.body == "end_effector" else (guided, rigid)
        word = next((each for each in words if np.isfinite(each)), 0.0)
        own[k] *= _CODED**2 * np.exp(_BELIEVED * word)
    return Noise(np.sqrt(own).T, _CODED * shaken, _of_rows(vision, poses))


def _expected(
    vision: Vision,
    view: View,
    poses: Poses,
    variance: Float64[np.ndarray, "frames markers 2"],
) -> Float64[np.ndarray, "markers 2"]:
    """Mean variances along x and y, by the discs [m²]; NaN of what was never seen."""
    means = np.full(variance.shape[1:], np.nan)
    for k, marker in enumerate(vision.markers):
        seen = np.isfinite(poses.places[:, k, 0])
        if not seen.any():
            continue
        place = np.median(poses.places[seen, k], axis=0)
        footprint = view.footprint(np.array([*place, marker.depth]))
        told = variance[seen & np.isfinite(variance[:, k, 0]), k]
        pixels = np.mean(told, axis=0) if len(told) else np.full(2, _UNKNOWN**2)
        means[k] = np.linalg.inv(footprint) ** 2 @ np.maximum(pixels, _LEAST_NOISE**2)
    return means


def _of_rigid(
    vision: Vision, poses: Poses, expected: Float64[np.ndarray, "markers 2"]
) -> Iterator[float]:
    """How much more a rigid body's distances scatter than its discs let expect [ln]."""
    for body, members in of_bodies(vision):
        if body != "end_effector" or not np.isfinite(expected[members]).all():
            continue
        own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
        off, along = _off_body(poses, members)
        if not len(off):
            continue
        projector = _projector(own)
        values, vectors = np.linalg.eigh(projector)
        free = off @ vectors[:, values > 0.5]
        scatter = sum(_trimmed(_straight(each, along)) for each in free.T)
        yield _ratio(scatter, np.diag(projector) @ expected[members].ravel())


def _of_guided(
    vision: Vision,
    poses: Poses,
    expected: Float64[np.ndarray, "markers 2"],
    shake: Float64[np.ndarray, " markers"],
) -> Iterator[float]:
    """How much more carriages' heights scatter than discs and shake let expect [ln].

    A shake that isn't known well moves them, too, and is told by the marks.
    """
    for k, marker in enumerate(vision.markers):
        seen = np.isfinite(poses.places[:, k, 0])
        if marker.body != "end_effector" and seen.any():
            along, height = poses.places[seen, k].T
            yield _ratio(_trimmed(_straight(height, along)), expected[k, 1] + shake[k])


def _ratio(scatter: float, expected: float) -> float:
    """Logarithm of a ratio of variances; what doesn't scatter at all was no measurement."""
    return float(np.log(max(scatter / expected, _LEAST_RATIO)))


def _off_body(
    poses: Poses, members: list[int]
) -> tuple[Float64[np.ndarray, "frames numbers"], Float64[np.ndarray, " frames"]]:
    """Where a rigid body's markers are in its own axes, and where it is [m]."""
    at = poses.places[:, members]
    seen = np.isfinite(at).all(axis=(1, 2)) & np.isfinite(poses.values["delta_e"])
    at, angle = at[seen], poses.values["delta_e"][seen]
    off = at - at.mean(axis=1, keepdims=True)
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x = cosine * off[..., 0] + sine * off[..., 1]
    y = cosine * off[..., 1] - sine * off[..., 0]
    return np.stack([x, y], axis=-1).reshape(len(at), -1), at[..., 0].mean(axis=1)


def _projector(own: Float64[np.ndarray, "markers 2"]) -> Float64[np.ndarray, "numbers numbers"]:
    """What a rigid body's pose leaves of its markers' errors: two moves and a turn are gone."""
    arm = own - own.mean(axis=0)
    moves = np.zeros((*own.shape, 3))
    moves[:, 0, 0] = moves[:, 1, 1] = 1.0
    moves[:, 0, 2], moves[:, 1, 2] = -arm[:, 1], arm[:, 0]
    flat = np.linalg.qr(moves.reshape(-1, 3))[0]
    return np.eye(len(flat)) - flat @ flat.T


def _of_shake(
    vision: Vision, view: View, poses: Poses, shake: Float64[np.ndarray, "2 markers"]
) -> Float64[np.ndarray, "2 markers"]:
    """What a shift of the picture makes of each marker's place along x and along y [m]."""
    moves = np.zeros_like(shake)
    for k, marker in enumerate(vision.markers):
        seen = np.isfinite(poses.places[:, k, 0])
        if seen.any() and shake[:, k].any():
            place = np.median(poses.places[seen, k], axis=0)
            footprint = view.footprint(np.array([*place, marker.depth]))
            moves[:, k] = np.sqrt(np.linalg.inv(footprint) ** 2 @ shake[:, k] ** 2)
    return moves


def _straight(
    values: Float64[np.ndarray, " frames"], along: Float64[np.ndarray, " frames"]
) -> Float64[np.ndarray, " frames"]:
    """Values without what changes slowly along the guides."""
    order = min(_ORDER, max(len(values) // _FRAMES - 1, 0))
    apart = along - along.mean()
    powers = (apart / (np.abs(apart).max() or 1.0))[:, None] ** np.arange(order + 1)
    left = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
    return left * np.sqrt(len(values) / max(len(values) - order - 1, 1))


def _of_rows(vision: Vision, poses: Poses) -> dict[str, float]:
    """What rows that have another time than the picture add, root mean square [m, rad].

    Most of a step from one order to the next is noise. What stands out is a kink, as where a
    torque is switched on, and there the step is no more than what it is off by.
    """
    rows = {}
    for name, steps in columns_of(vision, poses.unsure).items():
        size = np.abs(steps[np.isfinite(steps)])
        kink = size > _STANDS_OUT * np.median(size) if len(size) else size > 0
        off = np.where(kink, _OF_KINK, _OF_UNSURE) * size
        rows[name] = float(np.sqrt(np.mean(off**2))) if len(size) else 0.0
    return rows


def _trimmed(off: Float64[np.ndarray, " frames"]) -> float:
    """Mean square without the largest twentieth, which tells nothing of the others."""
    square = np.sort(off**2)
    kept = square[: max(1, int(np.ceil(_KEPT * len(square))))]
    return float(kept.mean() / _OF_KEPT)
