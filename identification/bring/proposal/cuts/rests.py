"""Where a recording rests, and what happens between.

The end-effector, an encoder or a command that moves shows as a range over a short time that
is out of its noise. What moves after a rest is an event of its own; a run is cut in the rest
before it, so that it begins at rest as a run has to.
"""

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import scipy.ndimage
from jaxtyping import Bool, Float64

from identification.campaign.types import AccelerometerStream, Run

HALF = 0.1
"""Half the time over which a range is taken [s]."""
FRAMES = 7
"""Frames over which the camera's scatter is taken: 0.23 s at 30 frames a second."""
REST = 0.15
"""Shortest rest between two events [s], beyond what the ranges widen them by."""
SHORTEST = 0.12
"""Shortest event [s]; a shorter one is a jump to another place, between two logs."""
MOVES = 3.0
"""Range or scatter over that at rest from which on it is motion [1]."""
STRONG = 12.0
"""The same of a knock, which is no command's [1]: some millimetres."""
DRIVEN = 6.0
"""The same of what a command drives [1]; less is a controller's chatter about a count."""
COMMAND = 0.05
"""Share of the largest command that a change must have to be one [1]."""
LEAD = 1.0
"""Time before an event that belongs to its run, where it rests as long [s]."""


@dataclasses.dataclass(frozen=True)
class Part:
    """A part of a recording with one event."""

    begin: float
    """First time [s] on the drive's clock."""
    end: float
    """Last time [s]."""


def parts(run: Run) -> list[Part]:
    """The parts of a recording, cut where it rests.

    Args:
        run: The recording as one run.

    Returns:
        One part for each event; one for all where there are fewer than two events.
    """
    time = run.drive.time
    motion, commanded = _motion(run), _commanded(run)
    events: list[tuple[float, float]] = []
    jumps: list[float] = []
    carried = None
    for begin, end in _spans(time, (motion > MOVES) | commanded):
        inside = (time >= begin) & (time <= end)
        if not (motion[inside] > MOVES).any():
            # A command that moves nothing is the first step of a staircase.
            carried = begin if carried is None else carried
        elif end - begin < SHORTEST + 2 * HALF and _is_jump(run, begin, end):
            jumps.append(end)
        elif motion[inside].max() > (DRIVEN if commanded[inside].any() else STRONG):
            events.append((begin if carried is None else carried, end))
            carried = None
        elif events:
            # What swells up once more at the end of a vibration belongs to it.
            events[-1] = (events[-1][0], end)
    if len(events) < 2:
        return [Part(float(time[0]), float(time[-1]))]
    cuts = _cuts(events, jumps, time)
    step = float(np.median(np.diff(time)))
    edges = [*cuts[1:], float(time[-1]) + step]
    return [
        Part(begin, float(time[np.searchsorted(time, end - step / 2) - 1]))
        for begin, end in zip(cuts, edges, strict=True)
    ]


def _cuts(
    events: Sequence[tuple[float, float]],
    jumps: Sequence[float],
    time: Float64[np.ndarray, " rows"],
) -> list[float]:
    """First time of each event's part: in the rest before it, after any jump."""
    cuts = [float(time[0])]
    for (_, before), (begin, _) in itertools.pairwise(events):
        early = max([before, *(jump for jump in jumps if before < jump < begin)])
        cut = max(early, begin - LEAD, early + 0.3 * (begin - early))
        cuts.append(float(time[np.searchsorted(time, cut)]))
    return cuts


def _is_jump(run: Run, begin: float, end: float) -> bool:
    """Whether the robot is elsewhere from one sample to the next, as two logs in one are."""
    if run.camera is None:
        return True
    camera = run.camera.time - (run.clock_offset or 0.0)
    around = (camera >= begin - HALF) & (camera <= end + HALF)
    x = run.camera.position[around, 0]
    x = x[np.isfinite(x)]
    if len(x) < 3:
        return True
    steps = np.abs(np.diff(x))
    # One step that is nearly all of the way.
    return bool(steps.max() > 0.9 * np.ptp(x))


def _spans(
    time: Float64[np.ndarray, " rows"], active: Bool[np.ndarray, " rows"]
) -> list[tuple[float, float]]:
    """Stretches of activity, those that are hardly apart together."""
    edges = np.flatnonzero(np.diff(np.r_[0, active.astype(int), 0]))
    spans = [
        (float(time[a]), float(time[b - 1]))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    ]
    joined: list[tuple[float, float]] = []
    for begin, end in spans:
        if joined and begin - joined[-1][1] < REST:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((begin, end))
    return joined


def _ranges(values: Float64[np.ndarray, "rows 2"], half: int) -> Float64[np.ndarray, "rows 2"]:
    size = (2 * half + 1, 1)
    high = scipy.ndimage.maximum_filter(values, size, mode="nearest")
    return high - scipy.ndimage.minimum_filter(values, size, mode="nearest")


def _half(run: Run) -> int:
    return max(1, round(HALF / float(np.median(np.diff(run.drive.time)))))


def _commanded(run: Run) -> Bool[np.ndarray, " rows"]:
    """Where the commands change."""
    largest = float(np.abs(run.drive.voltage).max())
    if largest == 0:
        return np.zeros(len(run.drive.time), dtype=bool)
    return (_ranges(run.drive.voltage, _half(run)) > COMMAND * largest).any(axis=1)


def _motion(run: Run) -> Float64[np.ndarray, " rows"]:
    """How far encoders and camera are out of their noise [1], `MOVES` where it is motion."""
    angle = run.drive.angle
    steps = np.abs(np.diff(angle, axis=0))
    resolution = np.array([_smallest(column) for column in steps.T])
    noise = 1.5 * np.quantile(steps, 0.5, axis=0)
    unit = np.maximum(np.maximum(3.5 * resolution, 8 * noise), 1e-9)
    motion = MOVES * (_ranges(angle, _half(run)) / unit).max(axis=1)
    if run.accelerometer is not None:
        motion = np.maximum(motion, _shaken(run.accelerometer, run.drive.time))
    if run.camera is None:
        return motion
    frames = run.camera.time - (run.clock_offset or 0.0)
    seen = _camera_motion(run.camera.position[:, [0, 2, 3, 4]])
    half = 0.5 * float(np.median(np.diff(frames)))
    place = np.clip(np.searchsorted(frames, run.drive.time - half), 0, len(frames) - 1)
    within = (run.drive.time >= frames[0] - half) & (run.drive.time <= frames[-1] + half)
    # Where a camera looks on, an encoder's few counts are no motion of their own.
    return np.maximum(np.where(within, 0.5, 1.0) * motion, np.where(within, seen[place], 0.0))


def _shaken(
    stream: AccelerometerStream, time: Float64[np.ndarray, " rows"]
) -> Float64[np.ndarray, " rows"]:
    """An accelerometer's scatter over that at rest [1], at the drive's instants."""
    size = max(3, round(2 * HALF / float(np.median(np.diff(stream.time)))))
    if len(stream.time) < 3 * size:
        return np.zeros(len(time))
    return np.interp(time, stream.time, _over_rest(stream.along, size, 1e-3), left=0, right=0)


def _over_rest(
    values: Float64[np.ndarray, " samples"], size: int, least: float
) -> Float64[np.ndarray, " samples"]:
    """The scatter about each sample over that at rest [1]."""
    values = values - np.median(values)
    mean = scipy.ndimage.uniform_filter1d(values, size, mode="nearest")
    square = scipy.ndimage.uniform_filter1d(values**2, size, mode="nearest")
    scatter = np.sqrt(np.maximum(square - mean**2, 0.0))
    # A tenth of the samples at rest are enough to tell the noise.
    return scatter / max(float(np.quantile(scatter, 0.1)), least)


def _smallest(steps: Float64[np.ndarray, " rows"]) -> float:
    """An encoder's resolution: the smallest step that it takes."""
    taken = steps[steps > 0]
    return float(taken.min()) if taken.size else 0.0


def _camera_motion(position: Float64[np.ndarray, "frames 4"]) -> Float64[np.ndarray, " frames"]:
    """The camera's scatter about each frame over that at rest [1]."""
    motion = np.zeros(len(position))
    if len(position) < 3 * FRAMES:
        return motion
    for column in position.T:
        seen = np.isfinite(column)
        if seen.sum() < 3 * FRAMES:
            continue
        filled = np.interp(np.arange(len(column)), np.flatnonzero(seen), column[seen])
        motion = np.maximum(motion, _over_rest(filled, FRAMES, 1e-5))
    return motion
