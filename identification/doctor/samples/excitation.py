"""What moves, and what it therefore can't tell."""

import numpy as np

from identification.doctor.case import Case, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.statistics import travel
from identification.doctor.words import finding

STILL_COUNTS = 3
"""Counts within which an encoder stands still."""

STILL_SIGMAS = 10
"""Standard deviations within which what a camera sees stands still: noise spans 6 to 8."""

DRIVEN = 0.2
"""Travel of a pulley [rad] that tells of its drive's inertia and damping."""

SWUNG = 0.003
"""Swing of the end-effector [m] off the line between the carriages that rings."""


def excitation(case: Case) -> tuple[Finding, ...]:
    """Runs in which nothing moves, and quantities of which no motion tells.

    Args:
        case: The campaign, put right.

    Returns:
        What was found, all of it notes.
    """
    found = [_none(record) for record in case.records if not _moves(record, case.rig)]
    poor = _untold(case)
    if poor and len(found) < len(case.records):
        found.append(_poor(case, poor))
    return tuple(found)


def _moves(record: Record, rig: Rig) -> bool:
    if np.ptp(record.angle, axis=0).max() > STILL_COUNTS * rig.count:
        return True
    if not record.filmed:
        return False
    seen = (record.position[:, column] for column in (X, Y))
    return max(map(travel, seen)) > STILL_SIGMAS * rig.position_sigma


def _untold(case: Case) -> list[str]:
    """Quantities that no run of the campaign moves."""
    commanded = [
        record
        for record in case.records
        if np.abs(record.voltage).max() > 0 and np.ptp(record.angle, axis=0).max() > DRIVEN
    ]
    slid = [record for record in commanded if record.filmed]
    untold = []
    if not commanded:
        untold += ["drive_inertia", "drive_damping"]
    if not slid:
        untold.append("friction_coefficient")
    if not any(_swings(record, case.rig) for record in case.filmed):
        untold.append("effective_pretension")
    return untold


def _swings(record: Record, rig: Rig) -> bool:
    x_e, _, lower, upper, y_e = record.position.T
    away = x_e - lower - (upper - lower) * y_e / rig.height
    return travel(away) > max(SWUNG, STILL_SIGMAS * rig.position_sigma)


def _none(record: Record) -> Finding:
    volts = float(np.abs(record.voltage).max())
    return finding(
        "excitation.none",
        "note",
        runs=[record.name],
        what=f"nothing moves; the largest command is {volts:.3g} V",
        evidence={"largest_V": volts},
    )


def _poor(case: Case, untold: list[str]) -> Finding:
    return finding(
        "excitation.poor",
        "note",
        runs=[record.name for record in case.records],
        what=f"no motion in these runs tells {', '.join(untold)}",
        evidence={"untold": untold},
    )
