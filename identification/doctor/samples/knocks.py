"""Knocks: when the end-effector was knocked, and for how long.

The camera sees the end-effector at rest, then not: the knock came a little before the first
frame that is out of the noise. When, and for how long, the frames about it tell together
(`identification.doctor.samples.push`).
"""

import dataclasses

from identification.campaign.types import Knock
from identification.doctor.case import Record, Rig
from identification.doctor.findings import Finding
from identification.doctor.samples.motion import Onset, first_command, onset
from identification.doctor.samples.push import USUAL, Push, push
from identification.doctor.words import finding

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
    if record.knock is not None and _possible(record, moved):
        return record, ()
    pushed = _knock(record, rig, moved)
    found = Knock(start=round(pushed.begin, 4), duration=round(pushed.length, 4))
    told = _finding(record, moved, pushed)
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


def _knock(record: Record, rig: Rig, moved: Onset) -> Push:
    """The push that fits the first frames; between two frames where they are too few."""
    fitted = push(record, rig, moved)
    if fitted is not None:
        return fitted
    first = max(moved.before, moved.after - EARLY, float(record.time[0]))
    begin = max(moved.after - USUAL, first)
    return Push(begin, moved.after - first, USUAL, USUAL)


def _finding(record: Record, moved: Onset, pushed: Push) -> Finding:
    missing = record.knock is None
    stated = "isn't stated" if missing else f"is stated at {record.knock.start:g} s"
    return finding(
        "knock.missing" if missing else "knock.wrong",
        "note" if missing else "contradiction",
        runs=[record.name],
        what=f"the knock {stated}; the end-effector begins to move between "
        f"{moved.before:.4g} and {moved.after:.4g} s, pushed from {pushed.begin:.4g} "
        f"± {pushed.begin_sigma:.2g} s on",
        stream="camera",
        column="x_e",
        row=moved.row,
        evidence={
            "stated_s": None if missing else record.knock.start,
            "between_s": [moved.before, moved.after],
            "start_s": round(pushed.begin, 4),
            "start_sigma_s": pushed.begin_sigma,
            "duration_s": round(pushed.length, 4),
            "duration_sigma_s": pushed.length_sigma,
        },
        mend={
            "do": "write [knock]",
            "run": record.name,
            "start": f"{pushed.begin:.4f} s",
            "duration": f"{pushed.length * 1e3:.1f} ms",
        },
    )
