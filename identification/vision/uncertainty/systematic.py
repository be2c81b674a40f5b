"""What doesn't vary from picture to picture: lens, marks and lateral colour."""

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Adjusted, View
from identification.vision.lens.adjusted import USUAL_ERROR
from identification.vision.settings.document import Vision
from identification.vision.spots.marks import colour_magnification
from identification.vision.uncertainty.columns import columns_of

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
    shifts += _by_disc(vision, view, places)
    variances: dict[str, float] = {}
    for shift in shifts:
        for name, values in columns_of(vision, shift).items():
            variances[name] = variances.get(name, 0.0) + float((values**2).mean())
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


def _by_disc(
    vision: Vision, view: View, places: Float64[np.ndarray, "samples markers 2"]
) -> list[Float64[np.ndarray, "samples markers 2"]]:
    """What all discs of a colour are off by, as marks are: a Bayer pattern shifts colours."""
    shifts = []
    for colour in sorted({marker.colour or "" for marker in vision.markers}):
        for error in np.eye(2) * USUAL_ERROR:
            shift = np.zeros_like(places)
            for k, marker in enumerate(vision.markers):
                if (marker.colour or "") == colour:
                    at = [places[:, k], np.full((len(places), 1), marker.depth)]
                    seen = view.pixels(np.concatenate(at, axis=-1)) + error
                    shift[:, k] = view.places(seen, marker.depth) - places[:, k]
            shifts.append(np.nan_to_num(shift))
    return shifts


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
