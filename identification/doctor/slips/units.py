"""Units that aren't what the header says."""

import math

import numpy as np

from identification.doctor.case import Case
from identification.doctor.slips.edits import ANGLES, POSITIONS, TIMES, VOLTAGES, Undone, scaled
from identification.doctor.slips.scales import ANGLE_FACTORS, LENGTH_FACTORS
from identification.doctor.slips.slip import Slip

TIME_FACTORS = ((1e-3, "ms as s"), (1e3, "s as ms"), (1e-6, "us as s"), (1e6, "s as us"))
"""What undoes a unit of time, and what it was."""

VOLT_FACTORS = ((1e-3, "mV as V"), (1e3, "V as mV"))
"""What undoes a unit of voltage, and what it was."""

AMPERES = 1 / 0.6
"""Volts for an ampere of the paper's amplifiers, section 4.1 [V/A]."""

APART = math.log(30.0)
"""Logarithm of the factor that both drives' largest commands may be apart."""


def _scale(identifier: str, what: str, columns: tuple[str, ...], factor: float) -> Slip:
    return Slip(identifier, what, lambda case: scaled(case, columns, factor))


def _of_one(what: str, column: str, factor: float) -> Slip:
    """One drive's commands; its largest is then far from the other's, as in no campaign."""
    own = VOLTAGES.index(column)

    def undo(case: Case) -> Undone | None:
        largest = [
            max(float(np.abs(record.voltage[:, k]).max()) for record in case.records)
            for k in (own, 1 - own)
        ]
        if min(largest) == 0 or abs(math.log(factor * largest[0] / largest[1])) > APART:
            return None
        return scaled(case, (column,), factor)

    return Slip("unit.voltage", f"{column}: {what}", undo)


def _of_limit(what: str, share: float) -> Slip:
    def undo(case: Case) -> Undone:
        return scaled(case, VOLTAGES, case.rig.voltage_limit * share)

    return Slip("unit.voltage", what, undo)


def _counts(case: Case) -> Undone:
    return scaled(case, ANGLES, case.rig.count)


ANGLE_UNITS: tuple[Slip, ...] = (
    *(_scale("unit.alpha", what, ANGLES, factor) for factor, what in ANGLE_FACTORS),
    Slip("unit.alpha", "counts as rad", _counts),
)
"""Both encoders in another unit."""

ROTATION_UNITS: tuple[Slip, ...] = tuple(
    _scale("unit.delta_e", what, ("delta_e",), factor)
    for factor, what in ((math.pi / 180, "degrees as rad"), (180 / math.pi, "rad as degrees"))
)
"""The rotation in another unit."""

LENGTH_UNITS: tuple[Slip, ...] = tuple(
    _scale("unit.position", what, POSITIONS, factor) for factor, what in LENGTH_FACTORS
)
"""The camera's lengths in another unit."""

TIME_UNITS: tuple[Slip, ...] = tuple(
    _scale(identifier, what, columns, factor)
    for factor, what in TIME_FACTORS
    for identifier, columns in (
        ("unit.time_drive", TIMES[:1]),
        ("unit.time_camera", TIMES[1:]),
        ("unit.time", TIMES),
    )
)
"""Time in another unit, in one stream or in both."""

VOLTAGE_UNITS: tuple[Slip, ...] = (
    *(_scale("unit.voltage", what, VOLTAGES, factor) for factor, what in VOLT_FACTORS),
    _scale("unit.voltage", "amperes as V", VOLTAGES, AMPERES),
    _of_limit("per cent of the limit as V", 1e-2),
    _of_limit("per mille of the limit as V", 1e-3),
    _of_limit("share of the limit as V", 1.0),
    *(_of_one(what, column, factor) for column in VOLTAGES for factor, what in VOLT_FACTORS),
)
"""The commands in another unit, of both drives or of one."""
