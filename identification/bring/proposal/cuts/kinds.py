"""What kind of run a part of a recording is."""

import numpy as np

from identification.campaign.types import Run
from identification.doctor.case import Rig, record_of
from identification.doctor.samples.motion import first_command, knocked, onset

STEPS = 8
"""Levels of a command up to which it is a step and not a staircase."""
LEVELS = 60
"""Levels up to which it is a staircase and no controller's command."""
MOVED = 0.008
"""Travel of the end-effector from which on it moves [m]: four times what noise spans."""


def kind_of(run: Run, rig: Rig, named: str) -> tuple[str, str]:
    """The kind of a run.

    Args:
        run: The run.
        rig: What is known of the rig.
        named: The kind that its file's name says, empty where it says none.

    Returns:
        The kind, and why.
    """
    if named:
        return named, "the log's name says so"
    record = record_of(run)
    filmed = record.filmed
    moved = onset(record, rig) if filmed else None
    if filmed and moved is not None:
        late = 0.06 if record.offset_known else 0.12
        commanded = first_command(record, rig, 0.02)
        if knocked(record, rig) or moved.after + late < commanded:
            return "pseudo_impulse", "the end-effector moves before anything is commanded"
    driven = np.abs(run.drive.voltage).max() > 0.005 * rig.voltage_limit
    if not driven and run.accelerometer is not None and not filmed:
        return "pseudo_impulse", "nothing is commanded, and an accelerometer listens"
    if not driven:
        if not filmed and np.ptp(run.drive.angle, axis=0).max() > 0:
            return "pseudo_impulse", "an encoder moves, and nothing is commanded"
        return "free", "nothing is commanded"
    if not filmed:
        return "motor_step", "no camera looks on"
    if np.nanmax(np.ptp(_seen(run), axis=0)) < MOVED and _turned(run) > 1.0:
        return "motor_step", "the drives turn, and the camera sees nothing move"
    return _by_commands(run)


def _by_commands(run: Run) -> tuple[str, str]:
    volts = run.drive.voltage
    largest = float(np.abs(volts).max())
    levels = max(len(np.unique(np.rint(column / (0.005 * largest)))) for column in volts.T)
    if levels <= STEPS:
        return "torque_step", "the commands are constant between few steps"
    if _climbs(volts, largest):
        return "breakaway", "the commands climb slowly, step by step or as a ramp"
    return "manoeuvre", "the commands change all the time, as a controller's do"


def _climbs(volts: np.ndarray, largest: float) -> bool:
    """Whether the command's size only grows, slowly, until it ends."""
    size = np.abs(volts[:, int(np.argmax(np.abs(volts).max(axis=0)))])
    top = int(np.argmax(size >= 0.999 * largest))
    rise = size[: top + 1]
    if len(rise) < 20:
        return False
    falls = np.diff(rise) < -0.02 * largest
    return not falls.any() and float(np.diff(rise).max()) < 0.3 * largest


def _seen(run: Run) -> np.ndarray:
    place = run.camera.position[:, [0, 4]]
    return place[np.isfinite(place).all(axis=1)]


def _turned(run: Run) -> float:
    """How far the drives turn [rad]."""
    return float(np.ptp(run.drive.angle, axis=0).max())
