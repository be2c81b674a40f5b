"""Knocks: when the end-effector was knocked, and for how long.

The camera sees the end-effector at rest, then not: the knock came a little before the first
frame that is out of the noise. Its speed right after tells when it left its place, and the
time at which it is fastest, how long it was pushed.
"""

import dataclasses

import numpy as np

from identification.campaign.types import Knock
from identification.doctor.case import Record, Rig, X
from identification.doctor.findings import Finding, Severity
from identification.doctor.samples.motion import Onset, first_command, onset
from identification.doctor.words import finding

USUAL = 0.03
"""Duration of a knock by hand [s], where the camera is too slow to tell."""

EARLY = 0.07
"""How much before the last frame at rest a stated knock may begin [s]: a push takes 30 ms,
and the end-effector 20 ms to leave the camera's noise."""

LATE = 0.03
"""How much after the first frame in motion a stated knock may begin [s]."""

UNKNOWN = 0.06
"""What a camera clock that isn't stated adds to both [s]."""


def knocks(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """A knock that isn't stated, or is stated at another time than it was.

    Args:
        record: The run, its clocks and scales put right.
        rig: What is known of the rig.

    Returns:
        The run with the knock that was found, and what was found.
    """
    if record.kind != "pseudo_impulse":
        return record, ()
    moved = onset(record, rig)
    if moved is None or first_command(record, rig, 0.05) < moved.before - EARLY:
        # That nothing moves is told as another kind of run.
        # Where there is an accelerometer, whoever uses it looks for the knock there.
        seen = (record.filmed and moved is None) or record.run.accelerometer is not None
        untold = record.knock is None and not seen
        return record, (_unseen(record),) if untold else ()
    found = _knock(record, moved)
    if record.knock is None:
        told = _finding("knock.missing", "note", record, moved, found)
    elif not _possible(record, moved):
        told = _finding("knock.wrong", "contradiction", record, moved, found)
    else:
        return record, ()
    return dataclasses.replace(record, knock=found), (told,)


def _unseen(record: Record) -> Finding:
    return finding(
        "knock.missing",
        "note",
        runs=[record.name],
        what="the knock isn't stated, and the camera doesn't show when it was"
        if record.filmed
        else "the knock isn't stated, and there is no camera that shows when it was",
        evidence={"stated_s": None},
    )


def _possible(record: Record, moved: Onset) -> bool:
    more = 0.0 if record.offset_known else UNKNOWN
    return moved.before - EARLY - more < record.knock.start < moved.after + LATE + more


def _knock(record: Record, moved: Onset) -> Knock:
    """The knock that fits the first frames."""
    seen = np.flatnonzero(np.isfinite(record.position[:, X]))
    time = record.frame_time[seen] - record.offset
    place = record.position[seen, X]
    first = int(np.searchsorted(seen, moved.row))
    rest = float(np.median(place[: max(first, 1)]))
    velocity = np.diff(place[first : first + 8]) / np.diff(time[first : first + 8])
    # Up to where it turns round: half a period on it is as fast again.
    turned = np.flatnonzero(velocity * np.sign(velocity[:1]) <= 0)
    speed = np.abs(velocity[: int(turned[0]) if turned.size else None])
    fastest = int(np.argmax(speed)) if speed.size else 0
    away = abs(float(place[first]) - rest)
    # It left its place with the speed that it has right after, half a push before.
    left = time[first] - (away / speed[0] if speed.size and speed[0] > 0 else 0.0)
    earliest = max(moved.before - USUAL / 2, float(record.time[0]))
    frame = float(np.median(np.diff(time)))
    length = USUAL
    if fastest > 1:  # still pushed two frames on
        length = float(time[first + fastest] - left)
    begin = float(np.clip(left - USUAL / 2, earliest, max(time[first] - frame / 6, earliest)))
    return Knock(start=round(begin, 4), duration=round(min(length, 0.3), 4))


def _finding(
    identifier: str, severity: Severity, record: Record, moved: Onset, knock: Knock
) -> Finding:
    stated = (
        "isn't stated" if record.knock is None else f"is stated at {record.knock.start:g} s"
    )
    return finding(
        identifier,
        severity,
        runs=[record.name],
        what=f"the knock {stated}; the end-effector begins to move between "
        f"{moved.before:.4g} and {moved.after:.4g} s",
        stream="camera",
        column="x_e",
        row=moved.row,
        evidence={
            "stated_s": None if record.knock is None else record.knock.start,
            "between_s": [moved.before, moved.after],
            "start_s": knock.start,
            "duration_s": knock.duration,
        },
        mend={
            "do": "write [knock]",
            "run": record.name,
            "start": f"{knock.start:g} s",
            "duration": f"{knock.duration * 1e3:g} ms",
        },
    )
