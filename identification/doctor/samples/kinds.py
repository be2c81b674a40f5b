"""Runs that aren't what their kind says."""

import numpy as np

from identification.doctor.case import Case, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.relations.responses import responses
from identification.doctor.samples.motion import first_command, knocked, onset
from identification.doctor.statistics import travel
from identification.doctor.words import finding

FIRST = 0.06
"""Time between command and motion that tells which came first [s]: two frames."""

UNKNOWN = 0.1
"""What a camera clock that isn't stated adds to it [s]."""

PUSHED = 0.003
"""Swing of the end-effector that a knock gives at least [m]."""

LIGHT = 1.5
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
        return _no_knock(record, rig, late)
    if moved is None or moved.swing < PUSHED or record.kind == "free":
        return []
    still = moved.before > record.time[0]
    if knocked(record, rig) or (still and moved.after + late < first_command(record, rig)):
        what = f"the end-effector moves at {moved.after:.3g} s, before any command"
        return [_finding(record, what, moved.row, [moved.after, first_command(record, rig)])]
    return []


def _no_knock(record: Record, rig: Rig, late: float) -> list[Finding]:
    moved = onset(record, rig)
    if moved is None:
        seen = travel(record.position[:, X])
        return [_finding(record, "a pseudo-impulse in which nothing moves", 0, [seen])]
    command = first_command(record, rig, 0.05)
    if command < moved.before - late:
        what = f"a command of {command:.3g} s precedes the motion of {moved.after:.3g} s"
        return [_finding(record, what, moved.row, [command, moved.after])]
    return []


def _by_gain(case: Case) -> list[Finding]:
    """A bare drive is lighter than one that pulls the robot."""
    gains, found = {}, []
    for record in case.records:
        if not record.filmed:
            alone = responses(case.only((record.name,)))
            gains[record.name] = [each for each in alone.values() if each.unexplained < 0.1]
    bare = [
        max(each.gain for each in gains[record.name])
        for record in case.records
        if record.kind == "motor_step" and gains.get(record.name)
    ]
    for record in case.records:
        mine = [each.gain for each in gains.get(record.name, ())]
        if not mine or not bare:
            continue
        if record.kind == "motor_step" and max(mine) * LIGHT < max(bare):
            share = max(mine) / max(bare)
            what = f"the drives accelerate {share:.2g} times as much as bare ones"
            found.append(_finding(record, what, None, [max(mine), max(bare)]))
        elif record.kind == "torque_step" and min(mine) * LIGHT**0.5 > max(bare):
            what = "the drives accelerate as bare ones do"
            found.append(_finding(record, what, None, [min(mine), max(bare)]))
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
