"""When a run is first commanded, and when its end-effector first moves."""

from typing import NamedTuple

import numpy as np

from identification.doctor.case import Q3, Q4, Record, Rig, X, Y
from identification.doctor.statistics import travel

COMMAND = 0.005
"""Share of the voltage limit that is a command, and no offset of the logger."""

BEGIN = 0.06
"""Share of the swing that the end-effector has passed when it has begun to move."""


OFFSET = 0.01
"""Share of the run's largest command that is a command, whatever unit it is in."""

PUSHED_COUNTS = 5
"""Counts that no rounding makes."""

SHAKEN = 0.008, 0.15
"""Swings of the end-effector about its carriages that a knock makes [m]."""

REST = 0.03
"""Time at the start without motion that makes a run one that begins at rest [s]."""


class Onset(NamedTuple):
    """The end-effector's first motion, on the drive's clock."""

    before: float
    """Time of the last frame at rest [s]; minus infinity if there is none."""
    after: float
    """Time of the first frame in motion [s]."""
    row: int
    """Index of that frame."""
    swing: float
    """How far the end-effector moves in all [m]."""


def first_command(record: Record, rig: Rig, share: float = COMMAND) -> float:
    """Time of the first command.

    Args:
        record: The run.
        rig: What is known of the rig.
        share: Share of the voltage limit that counts.

    Returns:
        The time [s], infinity if there is none.
    """
    on = np.abs(record.voltage).max(axis=1) > share * rig.voltage_limit
    return float(record.time[np.argmax(on)]) if on.any() else np.inf


def onset(record: Record, rig: Rig) -> Onset | None:
    """The first frame in which the end-effector is out of its noise.

    Args:
        record: The run, with frames that can be trusted, on clocks put right.
        rig: What is known of the rig.

    Returns:
        The onset, None if it doesn't move, or isn't seen.
    """
    if not record.filmed:
        return None
    seen = np.flatnonzero(np.isfinite(record.position[:, X]))
    if len(seen) < 8:
        return None
    time = record.frame_time[seen] - record.offset
    place = record.position[seen, X]
    moved = np.abs(place - np.median(place[:4]))
    swing = float(np.quantile(moved, 0.97))
    out = moved > max(8 * rig.position_sigma, BEGIN * swing)
    if not out.any():
        return None
    first = int(np.argmax(out))
    before = float(time[first - 1]) if first else -np.inf
    return Onset(before, float(time[first]), int(seen[first]), swing)


def knocked(record: Record, rig: Rig) -> bool:
    """Whether something else than the drives moved the robot.

    Args:
        record: A run with a camera.
        rig: What is known of the rig.

    Returns:
        True if the encoders move before any command, or the end-effector swings while the
        drives hold it.
    """
    return _pushed(record, rig) or _shaken(record, rig)


def _pushed(record: Record, rig: Rig) -> bool:
    """Whether the encoders move from rest before anything is commanded.

    Both are on the drive's own clock, so that no error of the camera's clock can pretend it.
    """
    size = np.abs(record.voltage).max(axis=1)
    largest = float(size.max())
    command = int(np.argmax(size > OFFSET * largest)) if largest > 0 else len(size)
    away = np.abs(record.angle - record.angle[0]).max(axis=1) > PUSHED_COUNTS * rig.count
    first = int(np.argmax(away)) if away.any() else len(size)
    rest = REST / record.period
    return rest < first < command


def _shaken(record: Record, rig: Rig) -> bool:
    """Whether the end-effector swings about the carriages, and nothing else moves.

    The camera alone tells it: no unit of an encoder, and no sign, can pretend it.
    """
    x_e, lower, upper, y_e = record.position[:, [X, Q3, Q4, Y]].T
    swing = travel(x_e - lower - (upper - lower) * y_e / rig.height)
    moved = max(travel(lower), travel(y_e))
    return SHAKEN[0] < swing < SHAKEN[1] and 3 * moved < swing
