"""Signs that are reversed, and signals that are exchanged."""

import numpy as np

from identification.doctor.case import Case, Record
from identification.doctor.slips.edits import (
    ANGLES,
    VOLTAGES,
    Undone,
    commanded,
    exchanged,
    mirrored,
    scaled,
)
from identification.doctor.slips.slip import Slip

ASKED = 100.0
"""What a controller asks for at most, over the limit: beyond it, it is a unit."""

_ALONG = ("x_e", "q_3", "q_4")


def _reversed(identifier: str, what: str, columns: tuple[str, ...]) -> Slip:
    return Slip(identifier, what, lambda case: scaled(case, columns, -1.0))


def _exchanged(identifier: str, what: str, *pairs: tuple[str, str]) -> Slip:
    return Slip(identifier, what, lambda case: exchanged(case, pairs))


def _drive_signs(drive: int) -> tuple[Slip, ...]:
    volt, angle, number = VOLTAGES[drive], ANGLES[drive], drive + 1
    return (
        _reversed(f"sign.motor_{number}", "voltage and angle reversed", (volt, angle)),
        _reversed(f"sign.voltage_{number}", "voltage reversed", (volt,)),
        _reversed(f"sign.alpha_{number}", "angle reversed", (angle,)),
    )


def _mirrored_y(case: Case) -> Undone:
    return mirrored(case, ("y_e",), case.rig.height)


def _mirrored_x(case: Case) -> Undone:
    return mirrored(case, _ALONG, case.rig.width)


def _mirrored_alone(column: str) -> Slip:
    return Slip(
        "sign.x_e",
        f"{column} alone counted leftwards",
        lambda case: mirrored(case, (column,), case.rig.width),
    )


SIGNS: tuple[Slip, ...] = (
    *_drive_signs(0),
    *_drive_signs(1),
    Slip("sign.y_e", "counted downwards", _mirrored_y),
    _reversed("sign.y_e", "negative", ("y_e",)),
    Slip("sign.x_e", "counted leftwards", _mirrored_x),
    _reversed("sign.x_e", "negative", _ALONG),
    _reversed("sign.delta_e", "counted the other way", ("delta_e",)),
    *(_mirrored_alone(column) for column in _ALONG),
    *(_reversed("sign.x_e", f"{column} alone negative", (column,)) for column in _ALONG),
)
"""Reversed signs."""

SWAPS: tuple[Slip, ...] = (
    _exchanged("swap.motors", "drives 1 and 2", VOLTAGES, ANGLES),
    _exchanged("swap.voltages", "commands 1 and 2", VOLTAGES),
    _exchanged("swap.alphas", "encoders 1 and 2", ANGLES),
    _exchanged("swap.carriages", "q_3 and q_4", ("q_3", "q_4")),
)
"""Exchanged signals."""


def _clipped(case: Case) -> Undone | None:
    limit = case.rig.voltage_limit
    if max(float(np.max(np.abs(record.voltage))) for record in case.records) > ASKED * limit:
        return None
    return commanded(case, lambda record: np.clip(record.voltage, -limit, limit), "clip")


def _scaled_to_limit(case: Case) -> Undone:
    """Commands of the robot that a controller scales until the largest one is admitted."""
    largest = max(float(np.max(np.abs(record.voltage))) for record in case.records)
    share = min(1.0, case.rig.voltage_limit / max(largest, 1e-12))

    def command(record: Record) -> np.ndarray:
        return record.voltage * share if record.filmed else record.voltage

    return commanded(case, command, "scale to the limit")


LIMITS: tuple[Slip, ...] = (
    Slip("command.before_limit", "clipped by the amplifier", _clipped),
    Slip("command.before_limit", "scaled to the limit", _scaled_to_limit),
)
"""Commands that were logged before the limit."""
