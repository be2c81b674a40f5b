"""What doesn't vary from picture to picture: lens, marks and lateral colour."""

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Lens, Marks, View, fit_plane
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.spots.marks import colour_magnification, mark_places, mark_radii

_LEAST_ERROR = 0.01  # px
_STEP = 0.05  # px
_OF_COLOUR = 0.5  # of the correction: so well is it known
_SHARED = 1.3  # for what all photos share, by rendered films


def systematic_variances(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    places: Float64[np.ndarray, "samples markers 2"],
) -> dict[str, float]:
    """Variances of the columns by what is the same in every picture.

    Args:
        vision: What is said of the video.
        marks: The marks' plane.
        mark_pixels: Where the marks are seen in the mean, NaN where they aren't [px].
        places: Where the markers were, in some pictures [m].

    Returns:
        Variances of the columns [m², rad²].
    """
    shifts = [
        *_by_lens(vision, marks, mark_pixels, places),
        *_by_marks(vision, marks, mark_pixels, places),
        _by_colour(vision, marks.view, places),
    ]
    variances: dict[str, float] = {}
    for shift in shifts:
        for name, value in _columns(vision, shift).items():
            variances[name] = variances.get(name, 0.0) + value**2
    return variances


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
        _SHARED
        * _moved(vision, marks.view, _refit(vision, mark_pixels, other, marks.view), places)
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
    error = max(np.sqrt((marks.residual**2).sum() / left), _LEAST_ERROR)
    shifts = []
    for k in np.flatnonzero(np.isfinite(mark_pixels[:, 0])):
        for axis in range(2):
            moved = mark_pixels.copy()
            moved[k, axis] += _STEP
            other = _refit(vision, moved, marks.view.lens, marks.view)
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


def _refit(
    vision: Vision, mark_pixels: Float64[np.ndarray, "marks 2"], lens: Lens, begin: View
) -> View:
    kept = np.isfinite(mark_pixels[:, 0])
    places, radii = mark_places(vision)[kept], mark_radii(vision)[kept]
    return fit_plane(lens, places, mark_pixels[kept], radii, begin=begin).view


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
