r"""The lens and the camera's place as the board and the marks have them together.

The board's photos leave the lens open in a few directions, and each of them moves everything
that is seen. The marks stand on the plane that is measured, and what the lens is off by bends
them out of their places: so they tell it, too. With $p$ the camera's place, $z$ the lens's
deviations in units of what the photos leave open, $r$ the marks' residuals, $J$ and $L$ their
slopes, the sum $|r + J p + L z|^2 / e^2 + |z|^2$ is made least, and the inverse of its
curvature is what both together leave open. Taking the lens for known and the plane fitted with
each lens that might be as well would be simpler: it says two to four times too much, and
places are off by that.

How far a mark is off by itself, $e$, is what makes the residuals most likely, the lens's part
in them seen to, with what discs in a steady picture are known to be off by as a weak prior.
"""

import dataclasses

import numpy as np
import scipy.linalg
from jaxtyping import Float64

from identification.vision.lens.lens import Lens
from identification.vision.lens.plane import Marks, fit_plane, pose_of, undistorted, view_of
from identification.vision.lens.view import View

USUAL_ERROR = 0.008
"""What a disc is off by in the mean of a steady camera's pictures [px]."""
_WEIGHT = 2.0  # residuals that the usual error counts as
_ERRORS = np.geomspace(5e-3, 3.0, 129)
_PLACE = 6
"""Numbers of the camera's place."""
_STEP, _SHARE = 1e-4, 1e-2  # rad or m; of a deviation


@dataclasses.dataclass(frozen=True)
class Adjusted:
    """The marks' plane by the adjusted lens, and what may be otherwise."""

    marks: Marks
    """The plane."""
    error: float
    """How far a mark is off by itself, of each coordinate [px]."""
    others: tuple[View, ...]
    """Cameras a standard deviation away, in directions that are independent."""


def adjusted(
    fit: Marks,
    places: Float64[np.ndarray, "marks 3"],
    seen: Float64[np.ndarray, "marks 2"],
    radius: Float64[np.ndarray, " marks"],
) -> Adjusted:
    """Adjust a lens to the marks, as far as its photos leave it open.

    Args:
        fit: The plane by the lens as the photos have it.
        places: The marks in the frame's coordinates [m].
        seen: Centroids of their images [px].
        radius: Radius of those that are discs, 0 of others [m].

    Returns:
        The plane by the adjusted lens, and what is left open.
    """
    pose, lens = pose_of(fit.view), fit.view.lens
    free = _PLACE + len(lens.deviations)

    def residual(change: Float64[np.ndarray, " free"]) -> Float64[np.ndarray, " numbers"]:
        other = view_of(_lens(lens, change[_PLACE:]), pose + change[:_PLACE])
        return undistorted(other, places, seen, radius).ravel()

    steps = np.diag([_STEP] * _PLACE + [_SHARE] * (free - _PLACE))
    slopes = np.stack(
        [(residual(each) - residual(-each)) / (2 * each.max()) for each in steps], axis=-1
    )
    here = residual(np.zeros(free))
    error = _error(here, slopes[:, :_PLACE], slopes[:, _PLACE:])
    stiff = np.concatenate([slopes / error, np.eye(free)[_PLACE:]])
    pull = np.concatenate([here / error, np.zeros(free - _PLACE)])
    change = -np.linalg.lstsq(stiff, pull, rcond=None)[0]
    better = _lens(lens, change[_PLACE:])
    start = view_of(better, pose + change[:_PLACE])
    marks = fit_plane(better, places, seen, radius, begin=start)
    # Columns of the triangle's inverse: their squares add up to the curvature's inverse.
    spread = scipy.linalg.inv(np.linalg.qr(stiff, mode="r")).T
    pose = pose_of(marks.view)
    others = [view_of(_lens(better, each[_PLACE:]), pose + each[:_PLACE]) for each in spread]
    return Adjusted(marks, error, tuple(others))


def _lens(lens: Lens, shares: Float64[np.ndarray, " directions"]) -> Lens:
    """A lens so many of its deviations away."""
    return lens.changed(shares @ lens.deviations)


def _error(
    residual: Float64[np.ndarray, " numbers"],
    by_place: Float64[np.ndarray, "numbers 6"],
    by_lens: Float64[np.ndarray, "numbers directions"],
) -> float:
    """A mark's own error, the most likely one [px]."""
    free = scipy.linalg.null_space(by_place.T)
    left, bent = free.T @ residual, free.T @ by_lens
    values, vectors = np.linalg.eigh(bent @ bent.T)
    square = (vectors.T @ left) ** 2
    variance = np.maximum(values, 0) + _ERRORS[:, None] ** 2
    told = (square / variance + np.log(variance)).sum(axis=1)
    usual = _WEIGHT * ((USUAL_ERROR / _ERRORS) ** 2 + 2 * np.log(_ERRORS))
    return float(_ERRORS[np.argmin(told + usual)])
