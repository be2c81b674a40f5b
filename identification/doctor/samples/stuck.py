"""Channels that stand still while they can't."""

import dataclasses

import numpy as np

from identification.doctor.case import CAMERA_COLUMNS, Q3, Q4, D, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.statistics import longest_still, travel
from identification.doctor.words import finding

STRONG = 0.25
"""Share of the voltage limit that moves every drive: a breakaway begins below it."""

WEAK = 0.1
"""Share that moves a drive while the other one turns by `TURNED`."""

TURNED = 0.5
"""Turn of the other drive [rad] that drags this one along, or is commanded with it."""

STILL = 0.12
"""Time [s] that an encoder can't stand still under a strong command: good ones do 3 ms."""

REPEATED = 8
"""Frames in which a noisy camera can't repeat a value."""


def stuck(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Stuck encoders, commands and camera columns; what is stuck doesn't count.

    Args:
        record: The run.
        rig: What is known of the rig, its limit the largest command if that is larger.

    Returns:
        The run without the stuck samples, and what was found.
    """
    found = []
    if record.kind != "pseudo_impulse":  # its drives may hold, and stand still
        for drive in (0, 1):
            told = _command(record, drive)
            if told:
                record = dataclasses.replace(record, commanded=False)
            else:
                record, told = _encoder(record, rig, drive)
            found += told
    if record.filmed:
        record, more = _camera(record)
        found += more
    return record, tuple(found)


def _encoder(record: Record, rig: Rig, drive: int) -> tuple[Record, list[Finding]]:
    first, stop = longest_still(record.angle[:, drive])
    volts = np.abs(record.voltage[first:stop, drive])
    alone = travel(record.angle[first:stop, 1 - drive]) < TURNED
    strong = volts > (STRONG if alone else WEAK) * rig.voltage_limit
    longest = max(8, STILL / record.period) if record.period < 0.05 else 8
    if strong.sum() <= longest:
        return record, []
    trusted = record.trusted.copy()
    trusted[first:] = False
    column = f"alpha_{drive + 1}"
    told = finding(
        "stuck.alpha",
        "contradiction",
        runs=[record.name],
        what=f"`{column}` stands still for {strong.sum() * record.period:.3g} s under "
        f"{np.median(volts[strong]):.3g} V",
        stream="drive",
        column=column,
        row=first,
        evidence={"samples": stop - first, "volts": float(np.median(volts[strong]))},
    )
    return dataclasses.replace(record, trusted=trusted), [told]


def _command(record: Record, drive: int) -> list[Finding]:
    moved = [travel(record.angle[:, each]) for each in (0, 1)]
    other = travel(record.voltage[:, 1 - drive])
    # In a bare drive's run, one drive may stand; the cable drags the other one along.
    enough = (0.5 if record.filmed else 0.2) * max(moved)
    if travel(record.voltage[:, drive]) > 0 or other <= 1 or moved[drive] <= enough:
        return []
    column = f"voltage_{drive + 1}"
    told = finding(
        "stuck.voltage",
        "contradiction",
        runs=[record.name],
        what=f"`{column}` is constant while `alpha_{drive + 1}` turns by "
        f"{moved[drive]:.3g} rad",
        stream="drive",
        column=column,
        row=0,
        evidence={"moved_rad": moved[drive], "other_moved_rad": moved[1 - drive]},
    )
    return [told]


def _camera(record: Record) -> tuple[Record, list[Finding]]:
    position, found = record.position.copy(), []
    for column in (X, D, Q3, Q4, Y):
        seen = np.flatnonzero(np.isfinite(position[:, column]))
        if len(seen) < 10:
            continue
        values = position[seen, column]
        first, stop = longest_still(values)
        outside = np.r_[values[: first + 1], values[stop - 1 :]]
        # A camera that rounds coarsely repeats values at rest: how often it does elsewhere
        # tells how likely so long a stretch is.
        often = float(np.mean(np.diff(outside) == 0)) if len(outside) > 8 else 0.0
        if stop - first < REPEATED or often ** (stop - first - 1) > 1e-6:
            continue
        position[seen[first:stop], column] = np.nan
        found.append(_stuck_column(record, column, seen, first, stop))
    return dataclasses.replace(record, position=position), found


def _stuck_column(
    record: Record, column: int, seen: np.ndarray, first: int, stop: int
) -> Finding:
    name = CAMERA_COLUMNS[column]
    return finding(
        "stuck.camera",
        "contradiction",
        runs=[record.name],
        what=f"`{name}` repeats a value over {stop - first} frames",
        stream="camera",
        column=name,
        row=int(seen[first]),
        evidence={"frames": stop - first},
        mend={"do": "empty the cells", "run": record.name, "column": name},
    )
