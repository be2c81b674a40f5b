"""Time stamps: jumps of a clock, and samples that are missing."""

import dataclasses
from typing import Literal

import numpy as np
from jaxtyping import Float64

from identification.campaign.notes import camera, drive
from identification.doctor.case import Record, Rig
from identification.doctor.findings import Finding
from identification.doctor.words import finding

LONGEST_PAUSE = 3000
"""Sample periods, or three times the run: a longer step is a clock that was set."""


def clocks(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Jumps and gaps of both streams' clocks; jumps are closed.

    Args:
        record: The run.
        rig: What is known of the rig.

    Returns:
        The run on clocks that go on, and what was found.
    """
    time, found = _stream(record, "drive", record.time, drive.GAP)
    record = dataclasses.replace(record, time=time)
    if record.frame_time is None:
        return record, found
    time, more = _stream(record, "camera", record.frame_time, camera.GAP)
    return dataclasses.replace(record, frame_time=time), (*found, *more)


def _stream(
    record: Record,
    stream: Literal["drive", "camera"],
    time: Float64[np.ndarray, " rows"],
    longest: float,
) -> tuple[Float64[np.ndarray, " rows"], tuple[Finding, ...]]:
    step = np.diff(time)
    period = float(np.median(step[step > 0]))
    span = float(np.sum(np.clip(step, 0, 50 * period)))
    jumps = np.flatnonzero((step <= 0) | (step > max(3 * span, LONGEST_PAUSE * period)))
    found = [_jump(record, stream, int(row), step) for row in jumps[:1]]
    if jumps.size:
        step = step.copy()
        step[jumps] = period
        time = time[0] + np.r_[0.0, np.cumsum(step)]
    gaps = np.flatnonzero(step > longest * period)
    if gaps.size:
        found.append(_gap(record, stream, gaps, step / period))
    return time, tuple(found)


def _jump(
    record: Record,
    stream: Literal["drive", "camera"],
    row: int,
    step: Float64[np.ndarray, " steps"],
) -> Finding:
    return finding(
        "time.jump",
        "contradiction",
        runs=[record.name],
        what=f"the {stream}'s clock jumps by {step[row]:.6g} s",
        stream=stream,
        column="t",
        row=row + 1,
        evidence={"jump_s": float(step[row]), "period_s": float(np.median(step))},
        mend={"do": "close the jump", "run": record.name, "stream": stream},
    )


def _gap(
    record: Record,
    stream: Literal["drive", "camera"],
    gaps: np.ndarray,
    steps: Float64[np.ndarray, " steps"],
) -> Finding:
    missing = [round(float(steps[row])) - 1 for row in gaps]
    what = "samples" if stream == "drive" else "frames"
    return finding(
        f"gap.{stream}",
        "note",
        runs=[record.name],
        what=f"{sum(missing)} {what} are missing in {len(missing)} gaps, "
        f"{max(missing)} in the longest",
        stream=stream,
        column="t",
        row=int(gaps[0]) + 1,
        evidence={"missing": sum(missing), "gaps": len(missing), "longest": max(missing)},
    )
