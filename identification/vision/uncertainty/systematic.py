"""What doesn't vary from picture to picture: lens, marks and lateral colour."""

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Adjusted, View
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.spots.marks import colour_magnification

_OF_COLOUR = 0.25  # of the correction: so well is it known


def systematic_variances(
    vision: Vision, fit: Adjusted, places: Float64[np.ndarray, "samples markers 2"]
) -> dict[str, float]:
    """Variances of the columns by what is the same in every picture.

    Args:
        vision: What is said of the video.
        fit: The lens and the marks' plane.
        places: Where the markers were, in some pictures [m].

    Returns:
        Variances of the columns [m², rad²].
    """
    view = fit.marks.view
    shifts = [_moved(vision, view, other, places) for other in fit.others]
    shifts.append(_by_colour(vision, view, places))
    variances: dict[str, float] = {}
    for shift in shifts:
        for name, value in _columns(vision, shift).items():
            variances[name] = variances.get(name, 0.0) + value**2
    return variances


def _by_colour(
    vision: Vision, view: View, places: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, "samples markers 2"]:
    """A quarter of what lateral colour moves the markers by: so well is it known."""
    shift = np.zeros_like(places)
    for k, marker in enumerate(vision.markers):
        own = _OF_COLOUR * colour_magnification(vision, marker, view.lens.lateral)
        at = np.concatenate([places[:, k], np.full((len(places), 1), marker.depth)], axis=-1)
        seen = view.lens.without_colour(view.pixels(at), own)
        shift[:, k] = view.places(seen, marker.depth) - places[:, k]
    return np.nan_to_num(shift)


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
