r"""How far each column may be off: what varies from picture to picture, and what doesn't.

Four things are told by the video itself.
Noise of a marker, with all that depends on where its disc lies on the pixels: a rigid body's
markers must keep their distances and a carriage its height, so what these do is error. It is
estimated from them, in pixels.
The marks' own errors, and with them the plane's: by the marks' residuals, and how a mark
that is off moves everything.
The lens: by the covariance of its fit to the board, the plane fitted anew with each lens that
might be as well.
Lateral colour, that bends each colour a little otherwise: see `lateral`.
A repeated measurement of a still robot would show the first alone, and be off by the others
without knowing.
"""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Lens, Marks, View, fit_plane
from identification.vision.poses import COLUMNS, Poses
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.spots.marks import mark_places, mark_radii

_LEAST_NOISE = 0.015
_STEP = 0.05
_KEPT = 0.95


@dataclasses.dataclass(frozen=True)
class Sigma:
    """Standard deviations of the columns of `camera.csv`."""

    columns: dict[str, float]
    """Of each but the time [m, rad]; NaN where a column is empty."""
    noise: Float64[np.ndarray, " markers"]
    """Of each marker from picture to picture [px]."""

    @property
    def position(self) -> float:
        """Root mean square of the positions' [m]."""
        known = [self.columns[name] for name in COLUMNS if name != "delta_e"]
        return float(np.sqrt(np.nanmean(np.square(known))))

    @property
    def angle(self) -> float:
        """The angle's [rad]."""
        return self.columns["delta_e"]


def sigma_of(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    poses: Poses,
) -> Sigma:
    """How far the poses may be off.

    Args:
        vision: What is said of the video.
        marks: The marks' plane.
        mark_pixels: Where the marks are seen in the mean, NaN where they aren't [px].
        poses: The poses.

    Returns:
        Standard deviations.
    """
    places = _typical(poses)
    noise = _noise(vision, marks.view, poses, places)
    shifts = [
        *_by_lens(vision, marks, mark_pixels, places),
        *_by_marks(vision, marks, mark_pixels, places),
    ]
    variances = dict.fromkeys(COLUMNS, 0.0)
    for shift in shifts:
        for name, value in _columns(vision, shift).items():
            variances[name] += value**2
    scale = _pixel_sizes(marks.view, vision, places)
    for body, members in of_bodies(vision):
        _add_noise(variances, vision, body, members, noise * scale)
    columns = {
        name: float(np.sqrt(variances[name]))
        if np.isfinite(poses.values[name]).any()
        else float("nan")
        for name in COLUMNS
    }
    return Sigma(columns, noise)


def _typical(poses: Poses) -> Float64[np.ndarray, "samples markers 2"]:
    """Where the markers were: some pictures from the whole of the track."""
    whole = np.flatnonzero(np.isfinite(poses.places[..., 0]).all(axis=1))
    if not len(whole):
        return np.nanmedian(poses.places, axis=0)[None]
    chosen = whole[np.linspace(0, len(whole) - 1, min(len(whole), 12)).astype(int)]
    return poses.places[chosen]


def _pixel_sizes(
    view: View, vision: Vision, places: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, " markers"]:
    """What a pixel is at each marker [m]."""
    sizes = []
    for k, marker in enumerate(vision.markers):
        at = np.nanmean(places[:, k], axis=0)
        if not np.isfinite(at).all():
            sizes.append(np.nan)
            continue
        footprint = view.footprint(np.array([*at, marker.depth]))
        sizes.append(1 / np.sqrt(abs(np.linalg.det(footprint))))
    return np.array(sizes)


def _noise(
    vision: Vision,
    view: View,
    poses: Poses,
    places: Float64[np.ndarray, "samples markers 2"],
) -> Float64[np.ndarray, " markers"]:
    """Of each marker and direction, by what its body doesn't allow [px]."""
    size = _pixel_sizes(view, vision, places)
    noise = np.full(len(vision.markers), np.nan)
    for body, members in of_bodies(vision):
        off = poses.off_body[:, members]
        if body == "end_effector":
            # Of 2 n numbers three are the pose, and one is left of two markers.
            left = (2 * len(members) - 3) / len(members)
            known = np.isfinite(off).all(axis=1)
            if known.any():
                noise[members] = np.sqrt(_trimmed(off[known]) / left) / size[members]
        else:
            noise[members] = np.sqrt([_trimmed(each) for each in off.T]) / size[members]
    usual = np.nanmedian(noise) if np.isfinite(noise).any() else _LEAST_NOISE
    return np.maximum(np.where(np.isfinite(noise), noise, usual), _LEAST_NOISE)


def _trimmed(off: Float64[np.ndarray, "..."]) -> float:
    """Mean square, but for the largest twentieth: one bad picture tells nothing of others."""
    square = np.sort((off[np.isfinite(off)] ** 2).ravel())
    kept = square[: max(1, int(np.ceil(_KEPT * len(square))))]
    return float(kept.mean()) if len(kept) else float("nan")


def _by_lens(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    places: Float64[np.ndarray, "samples markers 2"],
) -> list[Float64[np.ndarray, "samples markers 2"]]:
    """How each standard deviation of the lens moves the markers."""
    lens = marks.view.lens
    others = [lens.deviated(k) for k in range(len(lens.deviations))]
    return [
        _moved(vision, marks.view, _refit(vision, mark_pixels, other), places)
        for other in others
    ]


def _by_marks(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    places: Float64[np.ndarray, "samples markers 2"],
) -> list[Float64[np.ndarray, "samples markers 2"]]:
    """How a standard deviation of each mark moves the markers."""
    count = np.count_nonzero(np.isfinite(mark_pixels[:, 0]))
    left = max(2 * count - 6, 1)
    error = max(np.sqrt((marks.residual**2).sum() / left), _LEAST_NOISE)
    shifts = []
    for k in np.flatnonzero(np.isfinite(mark_pixels[:, 0])):
        for axis in range(2):
            moved = mark_pixels.copy()
            moved[k, axis] += _STEP
            other = _refit(vision, moved, marks.view.lens)
            shifts.append(_moved(vision, marks.view, other, places) * error / _STEP)
    return shifts


def _refit(vision: Vision, mark_pixels: Float64[np.ndarray, "marks 2"], lens: Lens) -> View:
    kept = np.isfinite(mark_pixels[:, 0])
    places, radii = mark_places(vision)[kept], mark_radii(vision)[kept]
    return fit_plane(lens, places, mark_pixels[kept], radii).view


def _moved(
    vision: Vision,
    view: View,
    other: View,
    places: Float64[np.ndarray, "samples markers 2"],
) -> Float64[np.ndarray, "samples markers 2"]:
    """Where the other camera has what this one sees at places, less these places."""
    shift = np.zeros_like(places)
    for k, marker in enumerate(vision.markers):
        at = np.concatenate([places[:, k], np.full((len(places), 1), marker.depth)], axis=-1)
        shift[:, k] = other.places(view.pixels(at), marker.depth) - places[:, k]
    return np.nan_to_num(shift)


def _columns(
    vision: Vision, shift: Float64[np.ndarray, "samples markers 2"]
) -> dict[str, float]:
    """What a shift of the markers makes of the columns, root mean square over the samples."""
    moved = {}
    for body, members in of_bodies(vision):
        if body == "end_effector":
            own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
            turn = _turn(own, shift[:, members])
            at = shift[:, members].mean(axis=1)
            middle = own.mean(axis=0)
            moved["x_e"] = at[:, 0] + turn * middle[1]
            moved["y_e"] = at[:, 1] - turn * middle[0]
            moved["delta_e"] = turn
        else:
            name = "q_3" if body == "lower_carriage" else "q_4"
            moved[name] = shift[:, members, 0].mean(axis=1)
    return {name: float(np.sqrt((values**2).mean())) for name, values in moved.items()}


def _turn(
    own: Float64[np.ndarray, "markers 2"], shift: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, " samples"]:
    """How a small shift of its markers turns a body, to first order [rad]."""
    arm = own - own.mean(axis=0)
    crossed = arm[:, 0] * shift[..., 1] - arm[:, 1] * shift[..., 0]
    return crossed.sum(axis=-1) / (arm**2).sum()


def _add_noise(
    variances: dict[str, float],
    vision: Vision,
    body: str,
    members: list[int],
    noise: Float64[np.ndarray, " markers"],
) -> None:
    """What independent noise of the markers [m] adds."""
    mean = float((noise[members] ** 2).mean())
    if body != "end_effector":
        name = "q_3" if body == "lower_carriage" else "q_4"
        variances[name] += mean / len(members)
        return
    own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
    middle = own.mean(axis=0)
    inertia = float(((own - middle) ** 2).sum())
    variances["delta_e"] += mean / inertia
    variances["x_e"] += mean / len(members) + mean / inertia * middle[1] ** 2
    variances["y_e"] += mean / len(members) + mean / inertia * middle[0] ** 2
