"""What a run's drive, and its start, are worth noting for.

What sensors say of each other, and faults that a run shows by itself, `doctor` tells.
"""

import math
from collections.abc import Iterator

import numpy as np

from identification.campaign.notes.note import Note, Observation, early_motion, rig_value, share
from identification.campaign.streams import CAMERA_FILE, DRIVE_FILE, EPOCH
from identification.campaign.types import Campaign, Run, encoder_resolution

GAP = 3.5
"""Sample periods without a sample that are a gap, of which the doctor tells: two samples are
lost, and it's no jitter."""

FEW = 4
"""Samples below which a run is a slip: a fit takes as many for its start alone."""

BEYOND = 1.02
"""Voltage over the limit from which on the doctor contradicts."""


def _sampling(run: Run, campaign: Campaign) -> Iterator[Note]:
    steps = np.diff(run.drive.time)
    period = float(np.median(steps))
    # Half a period: beyond it, a sample was late or is missing, and it's more than jitter.
    odd = (np.abs(steps - period) > period / 2) & (steps <= GAP * period)
    if odd.any():
        worst = int(np.argmax(np.where(odd, np.abs(steps - period), 0.0)))
        yield Note(
            what=f"irregular sampling: {share(odd)} of the steps are off the period of "
            f"{period * 1e3:.4g} ms, one of {steps[worst] * 1e3:.4g} ms at "
            f"t = {run.drive.time[worst]:.4g} s",
            cause="A gap holds the last command, which may not be what the drive was sent.",
            remedy="Log from the controller's own loop, at its own rate.",
        )


def _length(run: Run, campaign: Campaign) -> Iterator[Note]:
    samples = len(run.drive.time)
    if samples < FEW:
        yield Note(
            what=f"a run of {samples} samples, {run.drive.time[-1] - run.drive.time[0]:.3g} s",
            cause="So short a run tells nothing, and what else is said of it is by chance.",
            remedy="Log it again, or leave the run out; a cut file is exported anew.",
        )


def _clock(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.drive.time[0] >= EPOCH:
        yield Note(
            what="time stamps that count from 1970",
            cause="Knocks and cameras have to be on the same clock, and rarely are.",
            remedy="Take the first time off every time in the run's files.",
        )


def _start(run: Run, campaign: Campaign) -> Iterator[Note]:
    cable = run.kind not in ("motor_step",)
    if cable and run.camera is None and run.initial is None:
        yield Note(
            what="where the robot starts is unknown: neither camera.csv nor `[initial]`",
            cause="A fit begins every run at its start, and leaves out what has none.",
            remedy="Add `[initial]` with x_e and y_e to run.toml, measured with a ruler.",
        )


def _voltage_limit(run: Run, campaign: Campaign) -> Iterator[Note]:
    limit = rig_value("voltage_limit", campaign)
    largest = np.abs(run.drive.voltage).max(axis=1)
    # A thousandth of the limit: a logger's last digit, and half a count of 11 bits.
    clipped = largest >= limit * 0.999
    if clipped.any() and largest.max() <= BEYOND * limit:
        stated = "of [robot]" if "voltage_limit" in campaign.robot else "of the paper's rig"
        yield Note(
            what=f"voltage clipped at the limit {stated}, {limit:.4g} V, in "
            f"{share(clipped)} of the samples",
            cause="The drive gave all it had: the controller's loop was open for that time.",
            remedy="Fine to identify from; for tuning, repeat it with a slower reference.",
        )


def _encoder(run: Run, campaign: Campaign) -> Iterator[Note]:
    driven = np.abs(run.drive.voltage).max(axis=0) > 0
    travel = np.ptp(run.drive.angle, axis=0)
    step = campaign.sensors.encoder_sigma * math.sqrt(12)
    if campaign.counts_per_rev is not None:
        step = encoder_resolution(campaign.counts_per_rev)
    for motor in np.flatnonzero(driven):
        counts = travel[motor] / step
        if counts < 20:  # at fewer, the rounding is 5 % of the travel
            yield Note(
                what=f"encoder counts not resolved: `alpha_{motor + 1}` moves by "
                f"{counts:.3g} counts of {step * 1e3:.3g} mrad while its motor is driven",
                cause="The motion is lost in the encoder's rounding, or isn't logged at all.",
                remedy="Check the encoder and `counts_per_rev`, or drive it harder.",
            )


def excitation_start(run: Run) -> float | None:
    """Time of a run's first command or knock.

    Args:
        run: The run.

    Returns:
        The time [s], None if there is none.
    """
    commanded = np.flatnonzero(np.any(run.drive.voltage != 0, axis=1))
    starts = [] if commanded.size == 0 else [float(run.drive.time[commanded[0]])]
    if run.knock is not None:
        starts.append(run.knock.start)
    return min(starts, default=None)


def _no_excitation(run: Run, campaign: Campaign) -> Iterator[Note]:
    """Motion without a cause; where nothing moves either, the doctor tells."""
    turned = float(np.ptp(run.drive.angle, axis=0).max())
    moves = turned > 8 * campaign.sensors.encoder_sigma
    if excitation_start(run) is None and moves and run.kind in ("torque_step", "motor_step"):
        yield Note(
            what="nothing is commanded in the whole run, and a pulley turns by "
            f"{turned:.3g} rad",
            cause="The command isn't logged, or somebody moved the robot.",
            remedy="Check the logged voltage, or leave the run out.",
        )


def _no_rest(run: Run, campaign: Campaign) -> Iterator[Note]:
    start = excitation_start(run)
    if start is None:
        return
    rest = start - float(run.drive.time[0])
    if rest < 0.05:  # shorter than two frames of a camera at 30 fps
        yield Note(
            what=f"no rest at the start: the first command comes after {rest * 1e3:.3g} ms",
            cause="That the run starts at rest can't be seen, nor where it starts.",
            remedy="Log at least 0.1 s before the first command.",
        )


def _early_motion(run: Run, campaign: Campaign) -> Iterator[Note]:
    start = excitation_start(run)
    if start is None:
        return
    travel = float(np.ptp(run.drive.angle[run.drive.time <= start], axis=0).max())
    tolerance = 8 * campaign.sensors.encoder_sigma  # noise spans some 6 to 8 of its sigma
    if campaign.counts_per_rev is not None:
        tolerance = max(tolerance, 2 * encoder_resolution(campaign.counts_per_rev))
    if travel > tolerance:
        yield early_motion(f"a pulley turns by {travel * 1e3:.3g} mrad", start)


def _no_camera(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None and run.kind != "motor_step":
        yield Note(
            what=f"no {CAMERA_FILE}",
            cause="Without the camera, only the drive's side of this run counts.",
            remedy="Add the vision system's stream if there is one.",
        )


DRIVE_OBSERVATIONS: tuple[tuple[str, Observation], ...] = (
    (DRIVE_FILE, _length),
    (DRIVE_FILE, _clock),
    (DRIVE_FILE, _sampling),
    (DRIVE_FILE, _voltage_limit),
    (DRIVE_FILE, _encoder),
    (DRIVE_FILE, _no_excitation),
    (DRIVE_FILE, _no_rest),
    (DRIVE_FILE, _early_motion),
    ("", _no_camera),
    ("", _start),
)
"""What is looked at in every run, in the order of the notes, with the file that it is about."""
