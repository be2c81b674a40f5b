"""Poses of the bodies from where their markers are."""

import dataclasses

import numpy as np
from jaxtyping import Bool, Float64

from identification.vision.lens import View
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies, rigid_pose
from identification.vision.spots.marks import colour_magnification
from identification.vision.timing.clock import Clock
from identification.vision.timing.shutter import at_frame_times, interpolation_error
from identification.vision.timing.tripod import Shake

COLUMNS = ("x_e", "y_e", "delta_e", "q_3", "q_4")
"""Columns of `camera.csv` after the time."""
OF_BODY = {
    "end_effector": ("x_e", "y_e", "delta_e"),
    "lower_carriage": ("q_3",),
    "upper_carriage": ("q_4",),
}
"""Columns that a body's pose is."""
_OFF_BODY = 1.5e-3  # m: ten times what a marker is off by
_SCALE = 0.04  # of its usual size: a disc of 22 px is measured to 0.5 %
_ROUNDS = 6
_UNSURE = 1e-3  # m: no pose may be off by 3 mm


@dataclasses.dataclass(frozen=True)
class Poses:
    """What the bodies did."""

    values: dict[str, Float64[np.ndarray, " frames"]]
    """Each column of `camera.csv` but the time, NaN where it isn't known [m, rad]."""
    places: Float64[np.ndarray, "frames markers 2"]
    """Where each marker was, NaN where it isn't known [m]."""
    unsure: Float64[np.ndarray, "frames markers 2"]
    """How far it may be off as its row has another time than the picture [m]."""
    off_body: Float64[np.ndarray, "frames markers"]
    """How far markers of a rigid body are from where it would have them [m]."""
    whole: Bool[np.ndarray, "frames markers"]
    """Which markers were seen with nothing before them."""


def whole_markers(
    pixels: Float64[np.ndarray, "frames markers 2"],
    scale: Float64[np.ndarray, "frames markers"],
    hidden: Float64[np.ndarray, "frames markers"],
    *,
    most_hidden: float,
) -> Bool[np.ndarray, "frames markers"]:
    """Which markers have nothing before them, by their shape.

    Args:
        pixels: Where they are seen [px].
        scale: Their size over the expected one [1].
        hidden: Share that is covered [1].
        most_hidden: The most of it that still is nothing [1].

    Returns:
        Whether each is whole: nothing hides it, and its size is its own of other pictures.
    """
    clear = np.isfinite(pixels[..., 0]) & (hidden < most_hidden)
    usual = np.ones(scale.shape[1])
    for k in range(scale.shape[1]):
        if clear[:, k].any():
            usual[k] = np.median(scale[clear[:, k], k])
    return clear & (np.abs(scale / usual - 1) < _SCALE)


def poses_of(
    vision: Vision,
    view: View,
    clock: Clock,
    pixels: Float64[np.ndarray, "frames markers 2"],
    whole: Bool[np.ndarray, "frames markers"],
    shake: Shake,
) -> Poses:
    """The poses at the pictures' times.

    Args:
        vision: What is said of the video.
        view: Where the camera stands.
        clock: When which row is exposed.
        pixels: Where the markers are seen [px].
        whole: Which of them count.
        shake: How far each picture is shifted.

    Returns:
        The poses.
    """
    whole = whole.copy()
    for _ in range(_ROUNDS):
        places, unsure = _places(vision, view, clock, pixels, whole, shake)
        poses = _bodies(vision, places, unsure, whole)
        strangers = _strangers(poses.off_body)
        if not strangers.any():
            break
        # A stranger has its part in where its neighbours were, so they are found anew.
        whole &= ~strangers
    return poses


def _strangers(
    off_body: Float64[np.ndarray, "frames markers"],
) -> Bool[np.ndarray, "frames markers"]:
    """Markers that aren't where their body has them, by more than those before and after."""
    off = np.nan_to_num(np.abs(off_body))
    around = np.maximum.reduce([np.roll(off, step, axis=0) for step in (-2, -1, 1, 2)])
    return (off > _OFF_BODY) & (off >= around)


def _places(
    vision: Vision,
    view: View,
    clock: Clock,
    pixels: Float64[np.ndarray, "frames markers 2"],
    whole: Bool[np.ndarray, "frames markers"],
    shake: Shake,
) -> tuple[Float64[np.ndarray, "frames markers 2"], Float64[np.ndarray, "frames markers 2"]]:
    """Where each marker was at the pictures' times, and how unsure it is by its row [m]."""
    places, unsure = np.full(pixels.shape, np.nan), np.full(pixels.shape, np.nan)
    for k, marker in enumerate(vision.markers):
        steady = np.where(whole[:, k, None], pixels[:, k], np.nan)
        times = clock.frames + clock.offset(steady[:, 1])
        steady = steady - shake.at(clock.frames, times)
        own = colour_magnification(vision, marker, view.lens.lateral)
        steady = view.lens.without_colour(steady, own)
        if marker.diameter is not None:
            steady = steady - _offsets(view, steady, marker.depth, marker.diameter / 2)
        at = view.places(steady, marker.depth)
        places[:, k] = at_frame_times(at, times, clock.frames)
        unsure[:, k] = interpolation_error(at, times, clock.frames)
        places[np.hypot(*unsure[:, k].T) > _UNSURE, k] = np.nan
    return places, unsure


def _offsets(
    view: View, pixels: Float64[np.ndarray, "frames 2"], depth: float, radius: float
) -> Float64[np.ndarray, "frames 2"]:
    offsets = np.zeros_like(pixels)
    seen = np.isfinite(pixels[:, 0])
    if seen.any():
        at = view.places(pixels[seen], depth)
        at = np.concatenate([at, np.full((len(at), 1), depth)], axis=-1)
        offsets[seen] = view.centroid_offset(at, radius)
    return offsets


def _bodies(
    vision: Vision,
    places: Float64[np.ndarray, "frames markers 2"],
    unsure: Float64[np.ndarray, "frames markers 2"],
    whole: Bool[np.ndarray, "frames markers"],
) -> Poses:
    count = len(places)
    values = {name: np.full(count, np.nan) for name in COLUMNS}
    off = np.full(places.shape[:2], np.nan)
    for body, members in of_bodies(vision):
        own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
        for frame in range(count):
            seen = np.isfinite(places[frame, members, 0])
            if body == "end_effector":
                if np.count_nonzero(seen) < 2:
                    continue
                pose = rigid_pose(own[seen], places[frame, np.array(members)[seen]])
                off[frame, np.array(members)[seen]] = pose.residual
                if pose.residual.max() < _OFF_BODY:
                    values["x_e"][frame], values["y_e"][frame] = pose.place
                    values["delta_e"][frame] = pose.angle
            elif seen.any():
                name = "q_3" if body == "lower_carriage" else "q_4"
                along = places[frame, members] - own
                values[name][frame] = np.nanmean(along[:, 0])
        if body != "end_effector":
            _drop_off_guide(values, places, off, members, body)
    return Poses(values, places, unsure, off, whole)


def _drop_off_guide(
    values: dict[str, Float64[np.ndarray, " frames"]],
    places: Float64[np.ndarray, "frames markers 2"],
    off: Float64[np.ndarray, "frames markers"],
    members: list[int],
    body: str,
) -> None:
    """Carriages that have left their guide were something else."""
    name = "q_3" if body == "lower_carriage" else "q_4"
    for k in members:
        height = places[:, k, 1]
        if not np.isfinite(height).any():
            continue
        off[:, k] = height - np.nanmedian(height)
        values[name][np.abs(off[:, k]) > 2 * _OFF_BODY] = np.nan
