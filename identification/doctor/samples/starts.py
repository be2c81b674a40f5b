"""Starts: runs that begin in motion, and starts that can't be where the log says."""

import dataclasses

import numpy as np

from identification.doctor.case import Record, Rig
from identification.doctor.findings import Finding
from identification.doctor.words import finding

SHARE = 0.15
"""Speed at the start over the run's largest that is motion: good ones reach 0.05."""

COUNTS = 40
"""Counts in the first samples that are motion."""


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
    rows = len(record.time)
    first = max(2, min(rows // 50, 25))
    span = max(1, rows // 60)
    for drive in (0, 1):
        angle = record.angle[:, drive]
        largest = float(np.abs(angle[span::span] - angle[:-span:span]).max(initial=0.0)) / span
        begun = abs(float(angle[min(first, rows - 1)] - angle[0]))
        # Half a radian at the largest speed: below that, the run as a whole hardly moves.
        moves = largest * rows > 0.5 and begun > COUNTS * rig.count
        if moves and begun / first > SHARE * largest:
            column = f"alpha_{drive + 1}"
            speed = begun / first / record.period
            told = finding(
                "start.moving",
                "contradiction",
                runs=[record.name],
                what=f"`{column}` turns at {speed:.3g} rad/s in the first "
                f"{first * record.period * 1e3:.3g} ms",
                stream="drive",
                column=column,
                row=0,
                evidence={"speed": speed, "largest_speed": largest / record.period},
                mend={"do": "leave the run out", "run": record.name},
            )
            return (told,)
    return ()


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
