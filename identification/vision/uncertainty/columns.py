"""What small moves of the markers make of the columns of `camera.csv`."""

import numpy as np
from jaxtyping import Float64

from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies


def columns_of(
    vision: Vision, moves: Float64[np.ndarray, "samples markers 2"]
) -> dict[str, Float64[np.ndarray, " samples"]]:
    """How each column changes as the markers are moved, to first order.

    Args:
        vision: What is said of the video.
        moves: How far each marker is moved; NaN where that isn't known [m].

    Returns:
        Changes of the columns of the bodies that have markers [m, rad].
    """
    changes = {}
    for body, members in of_bodies(vision):
        if body == "end_effector":
            own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
            turn = _turn(own, moves[:, members])
            at = moves[:, members].mean(axis=1)
            middle = own.mean(axis=0)
            changes["x_e"] = at[:, 0] + turn * middle[1]
            changes["y_e"] = at[:, 1] - turn * middle[0]
            changes["delta_e"] = turn
        else:
            name = "q_3" if body == "lower_carriage" else "q_4"
            changes[name] = moves[:, members, 0].mean(axis=1)
    return changes


def _turn(
    own: Float64[np.ndarray, "markers 2"], moves: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, " samples"]:
    """How small moves of its markers turn a body [rad]."""
    arm = own - own.mean(axis=0)
    crossed = arm[:, 0] * moves[..., 1] - arm[:, 1] * moves[..., 0]
    return crossed.sum(axis=-1) / (arm**2).sum()
