"""Starts: runs that begin in motion, and starts that can't be where the log says.

An encoder that turns at the first row tells it, and so does an end-effector that swings while
the drives rest. A run that is commanded from its first row on begins at rest all the same: its
speed there is zero, however fast it is a few samples later.
"""

import dataclasses
import math

import numpy as np

from identification.doctor.case import Q3, Q4, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.samples.begin import FEWEST, at_begin
from identification.doctor.samples.motion import PUSHED_COUNTS, first_command
from identification.doctor.statistics import travel
from identification.doctor.words import finding

SHARE = 0.01
"""Speed at the first row over the run's largest that is motion."""

SURE = 6.0
"""Standard errors that the speed has to be of, too: good runs reach 2.7."""

SPAN = 0.02
"""Time over which an encoder is followed back to the first row [s]."""

MOST, PART = 25, 50
"""Rows that it takes at most, and the run's rows over them: a clock in another unit may put the
whole run into that time."""

SWINGS = 10.0
"""Swing of the end-effector over the camera's noise that is motion: at rest it reaches 5."""

PART_OF_WAY = 0.05
"""The same over the run's way [1]: where lengths are in another unit, so is their noise."""

CLOSE = 0.05
"""Time before the first other motion that doesn't count [s]: clocks may differ by it."""

QUIET = 0.4
"""How long after the first row a swing counts [s]."""

SEEN = 5
"""Frames before anything else moves that a swing is told by."""


def starts(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Whether the run begins at rest, and inside the frame.

    Args:
        record: The run.
        rig: What is known of the rig.

    Returns:
        The run, without a stated start that can't be, and what was found.
    """
    found = _moving(record, rig)
    place = record.initial
    if place is not None and not (0 < place.x_e < rig.width and 0 < place.y_e < rig.height):
        found = (*found, _outside(record, rig))
        record = dataclasses.replace(record, initial=None)
    return record, found


def _moving(record: Record, rig: Rig) -> tuple[Finding, ...]:
    rows = slice(min(MOST, max(FEWEST, len(record.time) // PART)))
    time, noise = record.time[rows] - record.time[0], rig.count / math.sqrt(12)
    for drive in (0, 1):
        begin = at_begin(time, record.angle[rows, drive], SPAN, noise)
        speed, largest = abs(begin.slope), _largest_speed(record, drive)
        # Half a radian at the largest speed: below that, the run as a whole hardly moves.
        moves = largest * (record.time[-1] - record.time[0]) > 0.5
        if moves and speed > max(SURE * begin.slope_error, SHARE * largest):
            column = f"alpha_{drive + 1}"
            return (
                _told(
                    record,
                    f"`{column}` turns at {speed:.3g} rad/s at the first row",
                    stream="drive",
                    column=column,
                    evidence={"speed": speed, "largest_speed": largest},
                ),
            )
    return ()


def _largest_speed(record: Record, drive: int) -> float:
    span = max(1, len(record.time) // 60)
    angle = record.angle[:, drive]
    way = float(np.abs(angle[span::span] - angle[:-span:span]).max(initial=0.0))
    return way / (span * record.period)


def swings(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Whether the end-effector swings before anything moves it.

    Args:
        record: The run, its clocks and scales put right.
        rig: What is known of the rig.

    Returns:
        The run, and what was found.
    """
    if not record.filmed or (record.kind == "pseudo_impulse" and record.knock is None):
        return record, ()
    turned = np.abs(record.angle - record.angle[0]).max(axis=1) > PUSHED_COUNTS * rig.count
    moved = float(record.time[np.argmax(turned)]) if turned.any() else np.inf
    knocked = np.inf if record.knock is None else record.knock.start
    end = min(moved, knocked, first_command(record, rig)) - CLOSE
    stamps = record.frame_time - record.offset - record.time[0]
    before = (stamps >= 0) & (stamps < min(end - record.time[0], QUIET))
    place = record.position[before, X]
    place = place[np.isfinite(place)]
    swing = float(np.ptp(place)) if len(place) >= SEEN else 0.0
    way = max(travel(record.position[:, column]) for column in (X, Q3, Q4, Y))
    if swing <= max(SWINGS * rig.position_sigma, PART_OF_WAY * way):
        return record, ()
    what = f"the end-effector swings by {swing * 1e3:.3g} mm before anything moves it"
    evidence = {"swing": swing, "noise": rig.position_sigma}
    return record, (_told(record, what, stream="camera", column="x_e", evidence=evidence),)


def _told(
    record: Record, what: str, *, stream: str, column: str, evidence: dict[str, float]
) -> Finding:
    return finding(
        "start.moving",
        "contradiction",
        runs=[record.name],
        what=what,
        stream=stream,
        column=column,
        row=0,
        evidence=evidence,
        mend={"do": "leave the run out", "run": record.name},
    )


def _outside(record: Record, rig: Rig) -> Finding:
    place = record.initial
    return finding(
        "pose.outside",
        "contradiction",
        runs=[record.name],
        what=f"[initial] is at ({place.x_e:.4g}, {place.y_e:.4g}) m, out of the frame of "
        f"{rig.width:.4g} m by {rig.height:.4g} m",
        evidence={"x_e": place.x_e, "y_e": place.y_e},
        mend={"do": "leave [initial] out", "run": record.name},
    )
