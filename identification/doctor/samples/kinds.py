"""Runs that aren't what their kind says."""

import math

import numpy as np

from identification.doctor.case import Q3, Case, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.relations.responses import plain_gain
from identification.doctor.samples.motion import first_command, knocked, onset
from identification.doctor.statistics import travel
from identification.doctor.words import finding

FIRST = 0.06
"""Time between command and motion that tells which came first [s]: two frames."""

UNKNOWN = 0.1
"""What a camera clock that isn't stated adds to it [s]."""

PUSHED = 0.003
"""Swing of the end-effector that a knock gives at least [m]."""

DRIVEN = 0.08
"""Travel of the lower carriage, or of the height, that no knock gives [m]."""

LIGHT = 1.2
"""Factor between the gains of bare drives, or of a bare one and the cable robot's."""


def kinds(case: Case) -> tuple[Finding, ...]:
    """Runs that can't be what their kind says.

    Args:
        case: The campaign, put right.

    Returns:
        What was found.
    """
    found = []
    for record in case.records:
        found += _by_motion(record, case.rig)
    return (*found, *_by_gain(case))


def _by_motion(record: Record, rig: Rig) -> list[Finding]:
    """What came first, the command or the motion, and whether anything moved."""
    if not record.filmed:
        return []
    moved = onset(record, rig)
    if record.kind == "motor_step":
        seen = [travel(record.position[:, column]) for column in (X, Y)]
        if sum(seen) > 40 * rig.position_sigma:
            return [_finding(record, f"the end-effector moves by {max(seen):.3g} m", 0, seen)]
        return []
    late = FIRST + (0.0 if record.offset_known else UNKNOWN)
    if record.kind == "pseudo_impulse":
        return _no_knock(record, rig)
    if moved is None or moved.swing < PUSHED or record.kind == "free":
        return []
    still = moved.before > record.time[0]
    if knocked(record, rig) or (still and moved.after + late < first_command(record, rig)):
        what = f"the end-effector moves at {moved.after:.3g} s, before any command"
        return [_finding(record, what, moved.row, [moved.after, first_command(record, rig)])]
    return []


def _no_knock(record: Record, rig: Rig) -> list[Finding]:
    """Nothing that moves, or motion of a hand's breadth under a command: no knock does that."""
    seen = [travel(record.position[:, column]) for column in (X, Q3, Y)]
    if onset(record, rig) is None:
        return [_finding(record, "nothing moves", 0, seen)]
    driven = np.abs(record.voltage).max() > 0.05 * rig.voltage_limit
    if driven and max(seen[1:]) > DRIVEN and not knocked(record, rig):
        return [_finding(record, f"the drives move it by {max(seen[1:]):.3g} m", 0, seen)]
    return []


def _by_gain(case: Case) -> list[Finding]:
    """A bare drive is lighter than one that pulls the robot."""
    gains = {
        record.name: gain
        for record in case.records
        if not record.filmed and (gain := plain_gain(record)) is not None
    }
    bare = [
        gains[record.name]
        for record in case.records
        if record.kind == "motor_step" and record.name in gains
    ]
    found = []
    for record in case.records:
        mine = gains.get(record.name)
        if mine is None or not bare:
            continue
        if record.kind == "motor_step" and mine * LIGHT < max(bare):
            what = f"the drives accelerate {mine / max(bare):.2g} times as much as bare ones"
            found.append(_finding(record, what, None, [mine, max(bare)]))
        elif record.kind == "torque_step" and mine * math.sqrt(LIGHT) > max(bare):
            what = "the drives accelerate as bare ones do"
            found.append(_finding(record, what, None, [mine, max(bare)]))
    return found


def _finding(record: Record, what: str, row: int | None, figures: list[float]) -> Finding:
    return finding(
        "label.kind",
        "contradiction",
        runs=[record.name],
        what=f'kind = "{record.kind}", but {what}',
        stream=None if row is None else "camera",
        column=None if row is None else "x_e",
        row=row,
        evidence={"figures": [float(np.nan_to_num(value, posinf=1e9)) for value in figures]},
    )
