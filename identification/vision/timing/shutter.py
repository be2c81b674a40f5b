r"""Where markers were at their picture's time, though each row has its own.

A rolling shutter exposes a picture's rows one after the other, the first and the last some
10 ms from the middle one, in which a fast marker goes a centimetre. Each marker is measured
at its own row's time $t_k + o(v_k)$; a polynomial through it and its neighbours tells where
it was at $t_k$: the sixth order through seven points, which follows a vibration of up to 9 Hz
at 30 pictures a second. A velocity from two neighbours would be simpler, and is off by
$a o^2 / 2$, 0.3 mm at 10 m/s². At the ends of a track, where the polynomial reaches out of
its points, it is of third order.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64, Int

_SIDES = 3
_APART = 5.0
_TIMELESS = 2e-4
_OF_LINE = 0.3


def interpolation_error(
    values: Float64[np.ndarray, "frames 2"],
    measured: Float64[np.ndarray, " frames"],
    wanted: Float64[np.ndarray, " frames"],
) -> Float64[np.ndarray, "frames 2"]:
    """How far `at_frame_times` may be off: by what it would be without its farthest neighbour.

    Args:
        values: What was measured; NaN where nothing was.
        measured: When it was [s].
        wanted: When it is wanted [s].

    Returns:
        The difference along each direction; NaN where there is no value.
    """
    error = np.full_like(values, np.nan)
    for k, chosen in _told_by(values, measured, wanted):
        if len(chosen) == 1:
            error[k] = 0.0
            continue
        whole = lagrange(measured[chosen], wanted[k]) @ values[chosen]
        fewer = np.delete(chosen, np.argmax(np.abs(measured[chosen] - wanted[k])))
        less = lagrange(measured[fewer], wanted[k]) @ values[fewer]
        # A line through two is far worse than the parabola that it stands for.
        error[k] = (whole - less) * (_OF_LINE if len(fewer) == 2 else 1)
    return error


def at_frame_times(
    values: Float64[np.ndarray, "frames 2"],
    measured: Float64[np.ndarray, " frames"],
    wanted: Float64[np.ndarray, " frames"],
) -> Float64[np.ndarray, "frames 2"]:
    """Values at other times than they were measured at, by their neighbours.

    Args:
        values: What was measured; NaN where nothing was.
        measured: When it was [s].
        wanted: When it is wanted [s].

    Returns:
        The values then; NaN where too few neighbours tell how they change.
    """
    result = np.full_like(values, np.nan)
    for k, chosen in _told_by(values, measured, wanted):
        result[k] = lagrange(measured[chosen], wanted[k]) @ values[chosen]
    return result


def _told_by(
    values: Float64[np.ndarray, "frames 2"],
    measured: Float64[np.ndarray, " frames"],
    wanted: Float64[np.ndarray, " frames"],
) -> Iterator[tuple[int, Int[np.ndarray, " samples"]]]:
    """Samples whose value is known at their picture's time, each with those that tell it.

    One that was measured at that time tells itself; any other needs two neighbours.
    """
    good = np.flatnonzero(np.isfinite(values[:, 0]) & np.isfinite(measured))
    interval = _interval(wanted)
    for place, k in enumerate(good):
        if abs(measured[k] - wanted[k]) <= _TIMELESS * interval:
            yield k, good[place : place + 1]
            continue
        chosen = _neighbours(good, place, measured, interval)
        if len(chosen) >= 3:
            yield k, chosen


def _interval(times: Float64[np.ndarray, " frames"]) -> float:
    """Usual time from a picture to the next; 0 where there is no next one."""
    steps = np.diff(times[np.isfinite(times)])
    return float(np.median(steps)) if len(steps) else 0.0


def _neighbours(
    good: Int[np.ndarray, " samples"],
    place: int,
    measured: Float64[np.ndarray, " frames"],
    interval: float,
) -> Int[np.ndarray, " chosen"]:
    """Three samples on each side."""
    k = good[place]
    before = [
        j
        for j in good[max(0, place - _SIDES) : place]
        if measured[k] - measured[j] < _APART * interval
    ]
    after = [
        j
        for j in good[place + 1 : place + 1 + _SIDES]
        if measured[j] - measured[k] < _APART * interval
    ]
    return np.array([*before, k, *after])


def lagrange(
    points: Float64[np.ndarray, " points"], at: float
) -> Float64[np.ndarray, " points"]:
    """Weights of the polynomial through points.

    Args:
        points: Where it is known.
        at: Where it is wanted.

    Returns:
        What each value counts there.
    """
    apart = points[:, None] - points
    np.fill_diagonal(apart, 1.0)
    reach = np.tile(at - points, (len(points), 1))
    np.fill_diagonal(reach, 1.0)
    return reach.prod(axis=1) / apart.prod(axis=1)
