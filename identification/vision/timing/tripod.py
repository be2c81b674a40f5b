"""A tripod that shakes, by the marks: they stand still, so what they do is the camera's."""

import numpy as np
from jaxtyping import Bool, Float64

from identification.vision.timing.clock import Clock
from identification.vision.timing.shutter import at_frame_times

_SIGNIFICANT = 4.0
_LEAST = 3
_ROUNDS = 3
_OF_MEDIAN = 1.4826  # of a normal deviate's median size, which blinks of a mark don't change


def mean_marks(
    pixels: Float64[np.ndarray, "frames marks 2"],
    shake: Float64[np.ndarray, "frames 2"],
) -> Float64[np.ndarray, "marks 2"]:
    """Where the marks are in the mean, the shake taken off.

    Args:
        pixels: Where they are seen; NaN where they aren't [px].
        shake: How far each picture is shifted [px].

    Returns:
        Means of the middle half; NaN where a mark was never seen [px].
    """
    steady = pixels - shake[:, None]
    means = np.full(steady.shape[1:], np.nan)
    for k in range(steady.shape[1]):
        seen = np.sort(steady[np.isfinite(steady[:, k, 0]), k], axis=0)
        if len(seen):
            quarter = len(seen) // 4
            means[k] = seen[quarter : len(seen) - quarter].mean(axis=0)
    return means


def shake_of(
    pixels: Float64[np.ndarray, "frames marks 2"],
    clock: Clock,
    usable: Bool[np.ndarray, " frames"],
) -> Float64[np.ndarray, "frames 2"]:
    """How far each picture is shifted.

    A mark's noise is in it, too, so it is taken for a shake only where the marks move
    together by more than they do each on its own; a steady camera's pictures are left alone.

    Args:
        pixels: Where the marks are seen; NaN where they aren't [px].
        clock: When which row is exposed.
        usable: Pictures that aren't doubled.

    Returns:
        The shift at each picture's time [px]; zeros if it is none.
    """
    still = np.zeros((len(pixels), 2))
    shake = still
    counted = np.where(usable[:, None, None], pixels, np.nan)
    for _ in range(_ROUNDS):
        apart = counted - mean_marks(counted[usable], shake[usable])
        shift = _means(apart)
        within = np.nanmean((apart - shift[:, None]) ** 2)
        count = max(np.isfinite(pixels[..., 0]).sum(axis=1).mean(), 1.0)
        shared = np.nanmean((shift[usable] - np.nanmean(shift[usable], axis=0)) ** 2)
        if not shared > _SIGNIFICANT * within / count:
            return still
        # Each by its own row's time: the mean of all is that of no time.
        at_frames = [
            at_frame_times(own, clock.frames + clock.offset(rows), clock.frames)
            for own, rows in zip(apart.swapaxes(0, 1), pixels[..., 1].T, strict=True)
        ]
        shake = _filled(_means(np.stack(at_frames, axis=1)))
    return shake


def shake_at(
    shake: Float64[np.ndarray, "frames 2"],
    times: Float64[np.ndarray, " frames"],
    wanted: Float64[np.ndarray, " frames"],
) -> Float64[np.ndarray, "frames 2"]:
    """The shift at a marker's own row.

    Args:
        shake: The shift at the pictures' times [px].
        times: These times [s].
        wanted: The row's times [s].

    Returns:
        The shift then [px].
    """
    if not shake.any():
        return np.zeros_like(shake)
    return _filled(at_frame_times(shake, times, wanted))


def shake_error(
    pixels: Float64[np.ndarray, "frames marks 2"],
    clock: Clock,
    shake: Float64[np.ndarray, "frames 2"],
) -> Float64[np.ndarray, " 2"]:
    """How far the shift at a row's own time is off: by the marks, which stand still.

    A shift is known at the pictures' times, and between them it goes on shaking. So a mark is
    seen to move by what its row's shift is off by, and so is a marker.

    Args:
        pixels: Where the marks are seen; NaN where they aren't [px].
        clock: When which row is exposed.
        shake: The shift at each picture's time; zeros if it is none [px].

    Returns:
        Standard deviation along each direction, zeros without a shake [px].
    """
    if not shake.any():
        return np.zeros(2)
    errors = []
    for own in pixels.swapaxes(0, 1):
        times = clock.frames + clock.offset(own[:, 1])
        left = own - shake_at(shake, clock.frames, times)
        left = left[np.isfinite(left[:, 0])]
        if len(left):
            errors.append(np.median(np.abs(left - np.median(left, axis=0)), axis=0))
    return _OF_MEDIAN * np.mean(errors, axis=0) if errors else np.zeros(2)


def _means(apart: Float64[np.ndarray, "frames marks 2"]) -> Float64[np.ndarray, "frames 2"]:
    """Mean over the marks that are seen; NaN with too few."""
    enough = np.isfinite(apart[..., 0]).sum(axis=1) >= _LEAST
    means = np.full((len(apart), 2), np.nan)
    means[enough] = np.nanmean(apart[enough], axis=1)
    return means


def _filled(shift: Float64[np.ndarray, "frames 2"]) -> Float64[np.ndarray, "frames 2"]:
    """Shifts that aren't known, between those that are."""
    known = np.isfinite(shift[:, 0])
    if not known.any():
        return np.zeros_like(shift)
    places = np.arange(len(shift))
    return np.stack(
        [np.interp(places, places[known], column[known]) for column in shift.T], axis=-1
    )
