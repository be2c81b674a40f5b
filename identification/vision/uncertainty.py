r"""How far each column may be off: what varies from picture to picture, and what doesn't.

Four things are told by the video itself.
Noise of a marker, with all that depends on where its disc lies on the pixels: a rigid body's
markers must keep their distances and a carriage its height, so what these do is error. It is
estimated from them, in pixels.
The marks' own errors, and with them the plane's: by the marks' residuals, and how a mark
that is off moves everything.
The lens: by the covariance of its fit to the board, the plane fitted anew with each lens that
might be as well.
Lateral colour, which is corrected by what the board tells of it: see `lens.lateral`.
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
from identification.vision.spots.marks import colour_magnification, mark_places, mark_radii

_LEAST_NOISE = 0.01
_STEP = 0.05
_KEPT = 0.8
_OF_KEPT = 0.4377
_SHARED = 1.3
_OF_UNSURE = 0.18
_OF_COLOUR = 0.5


@dataclasses.dataclass(frozen=True)
class Sigma:
    """Standard deviations of the columns of `camera.csv`."""

    columns: dict[str, float]
    """Of each but the time [m, rad]; NaN where a column is empty."""
    noise: Float64[np.ndarray, "2 markers"]
    """Of each marker from picture to picture, along x and along y [px]."""

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
    misfit: Float64[np.ndarray, " markers"],
) -> Sigma:
    """How far the poses may be off.

    Args:
        vision: What is said of the video.
        marks: The marks' plane.
        mark_pixels: Where the marks are seen in the mean, NaN where they aren't [px].
        poses: The poses.
        misfit: How much the markers' discs are unlike their shape [1].

    Returns:
        Standard deviations.
    """
    places = _typical(poses)
    noise = _noise(vision, marks.view, poses, places, misfit)
    shifts = [
        *_by_lens(vision, marks, mark_pixels, places),
        *_by_marks(vision, marks, mark_pixels, places),
        _by_colour(vision, marks.view, places),
    ]
    variances = dict.fromkeys(COLUMNS, 0.0)
    for shift in shifts:
        for name, value in _columns(vision, shift).items():
            variances[name] += value**2
    metres = noise * _pixel_sizes(marks.view, vision, places)
    rows = _of_rows(poses)
    for body, members in of_bodies(vision):
        _add_noise(variances, vision, body, members, metres[:, members], rows[:, members])
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
    misfit: Float64[np.ndarray, " markers"],
) -> Float64[np.ndarray, "2 markers"]:
    """Of each marker along x and along y, by what its body doesn't allow [px].

    Two markers beside each other tell by their distance how noisy they are along x, and a
    carriage by its height along y. What tells a direction stands for all markers, as their
    discs' misfits are: partly, as noise of the pixels has its part in both. A distance shows
    errors that are opposite to each other, as of a plate's two edges in a fast picture, and
    that the body's middle doesn't have; so the geometric mean of both directions is taken
    where the distance says more than the height.
    """
    size = _pixel_sizes(view, vision, places)
    share = np.sqrt(misfit / np.nanmean(misfit))
    told: list[list[float]] = [[], []]
    for body, members in of_bodies(vision):
        off = poses.off_body[:, members] / (size * share)[members]
        if body != "end_effector":
            told[1] += [np.sqrt(_trimmed(each)) for each in off.T]
            continue
        # Of 2 n numbers three are the pose, and one is left of two markers.
        left = (2 * len(members) - 3) / len(members)
        own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
        wide = np.ptp(own, axis=0)
        ways = (0, 1) if len(members) > 2 else (int(wide[1] > wide[0]),)
        for way in ways:
            told[way].append(np.sqrt(_trimmed(off[np.isfinite(off).all(axis=1)]) / left))
    known = [[each for each in way if np.isfinite(each)] for way in told]
    every = [each for way in known for each in way] or [_LEAST_NOISE]
    usual = [np.sqrt(np.mean(np.square(way or every))) for way in known]
    usual[0] = min(usual[0], np.sqrt(usual[0] * usual[1]))
    return np.maximum(np.array(usual)[:, None] * share, _LEAST_NOISE)


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


def _by_lens(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    places: Float64[np.ndarray, "samples markers 2"],
) -> list[Float64[np.ndarray, "samples markers 2"]]:
    """How each standard deviation of the lens moves the markers.

    It is somewhat more than the photos' differences say: what they share, as a board that
    isn't flat, isn't in them.
    """
    lens = marks.view.lens
    others = [lens.deviated(k) for k in range(len(lens.deviations))]
    return [
        _SHARED * _moved(vision, marks.view, _refit(vision, mark_pixels, other), places)
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


def _by_colour(
    vision: Vision, view: View, places: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, "samples markers 2"]:
    """A half of what lateral colour moves the markers by: so well is it known."""
    shift = np.zeros_like(places)
    for k, marker in enumerate(vision.markers):
        own = _OF_COLOUR * colour_magnification(vision, marker, view.lens.lateral)
        at = np.concatenate([places[:, k], np.full((len(places), 1), marker.depth)], axis=-1)
        seen = view.lens.without_colour(view.pixels(at), own)
        shift[:, k] = view.places(seen, marker.depth) - places[:, k]
    return np.nan_to_num(shift)


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
    noise: Float64[np.ndarray, "2 members"],
    rows: Float64[np.ndarray, "2 members"],
) -> None:
    """What independent noise of the markers adds, and their rows' times, common to all [m]."""
    along_x, along_y = (noise**2).mean(axis=1)
    rows_x, rows_y = (rows**2).mean(axis=1)
    if body != "end_effector":
        name = "q_3" if body == "lower_carriage" else "q_4"
        variances[name] += along_x / len(members) + rows_x
        return
    own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
    middle = own.mean(axis=0)
    arm = own - middle
    # A marker turns the body by its move across its arm.
    inertia = (arm**2).sum()
    turn = ((arm[:, 0] ** 2).sum() * along_y + (arm[:, 1] ** 2).sum() * along_x) / inertia**2
    variances["delta_e"] += turn
    variances["x_e"] += along_x / len(members) + turn * middle[1] ** 2 + rows_x
    variances["y_e"] += along_y / len(members) + turn * middle[0] ** 2 + rows_y
