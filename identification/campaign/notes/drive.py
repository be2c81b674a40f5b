"""What a run's drive, and its start, are worth noting for."""

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.campaign.notes.note import Note, Observation, rig_value, share
from identification.campaign.read import RUN_FILE
from identification.campaign.streams import CAMERA_FILE, DRIVE_FILE
from identification.campaign.types import Campaign, Run, encoder_resolution


def _extra_columns(run: Run, campaign: Campaign) -> Iterator[Note]:
    for file, stream in ((DRIVE_FILE, run.drive), (CAMERA_FILE, run.camera)):
        if stream is None or not stream.extra:
            continue
        yield Note(
            file=f"{run.name}/{file}",
            what=f"columns that are kept and ignored: {', '.join(stream.extra)}",
            cause="The format has no column of these names.",
            remedy="Nothing to do, unless one of them is a misspelt column of the format.",
        )


def _sampling(run: Run, campaign: Campaign) -> Iterator[Note]:
    steps = np.diff(run.drive.time)
    period = float(np.median(steps))
    # Half a period: beyond it, a sample was late or is missing, and it's more than jitter.
    odd = np.abs(steps - period) > period / 2
    if odd.any():
        worst = int(np.argmax(np.abs(steps - period)))
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"irregular sampling: {share(odd)} of the steps are off the period of "
            f"{period * 1e3:.4g} ms, one of {steps[worst] * 1e3:.4g} ms at "
            f"t = {run.drive.time[worst]:.4g} s",
            cause="A gap holds the last command, which may not be what the drive was sent.",
            remedy="Log from the controller's own loop, at its own rate.",
        )


def _voltage_limit(run: Run, campaign: Campaign) -> Iterator[Note]:
    limit = rig_value("voltage_limit", campaign)
    largest = np.abs(run.drive.voltage).max(axis=1)
    # A thousandth of the limit: a logger's last digit, and half a count of 11 bits.
    beyond, clipped = largest > limit * 1.001, largest >= limit * 0.999
    stated = "of [robot]" if "voltage_limit" in campaign.robot else "of the paper's rig"
    if beyond.any():
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"voltage beyond the limit {stated}: {largest.max():.4g} V, limit "
            f"{limit:.4g} V, in {share(beyond)} of the samples",
            cause="The command was logged before saturation, or the limit is another one.",
            remedy="Log the command after saturation, or set `voltage_limit` in [robot].",
        )
    elif clipped.any():
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
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
                file=f"{run.name}/{DRIVE_FILE}",
                what=f"encoder counts not resolved: `alpha_{motor + 1}` moves by "
                f"{counts:.3g} counts of {step * 1e3:.3g} mrad while its motor is driven",
                cause="The motion is lost in the encoder's rounding, or isn't logged at all.",
                remedy="Check the encoder and `counts_per_rev`, or drive it harder.",
            )
    yield from _encoder_jumps(run)


def _encoder_jumps(run: Run) -> Iterator[Note]:
    speed = np.abs(np.diff(run.drive.angle, axis=0) / np.diff(run.drive.time)[:, None])
    # 1000 rad/s at the pulley is 9500 turns a minute: no geared drive gets there.
    rows, motors = np.nonzero(speed > 1000)
    if rows.size:
        row, motor = int(rows[0]), int(motors[0])
        jump = run.drive.angle[row + 1, motor] - run.drive.angle[row, motor]
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"`alpha_{motor + 1}` jumps by {jump:.4g} rad at "
            f"t = {run.drive.time[row]:.4g} s, and {rows.size - 1} times more",
            cause="A counter that overflowed, or a lost encoder line.",
            remedy="Unwrap the counter when logging, and repeat the run.",
        )


def _knock(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.kind == "pseudo_impulse" and run.knock is None:
        yield Note(
            file=f"{run.name}/{RUN_FILE}",
            what="a pseudo-impulse without [knock]",
            cause="When the end-effector was knocked isn't known.",
            remedy="Add [knock] with its start and duration.",
        )


def _excitation_start(run: Run) -> float | None:
    """Time of the first command or knock [s], None if there is none."""
    commanded = np.flatnonzero(np.any(run.drive.voltage != 0, axis=1))
    starts = [] if commanded.size == 0 else [float(run.drive.time[commanded[0]])]
    if run.knock is not None:
        starts.append(run.knock.start)
    return min(starts, default=None)


def _rest(run: Run, campaign: Campaign) -> Iterator[Note]:
    start = _excitation_start(run)
    if start is None:
        if run.kind == "pseudo_impulse" and run.knock is None:
            return
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what="nothing is commanded and nothing is knocked in the whole run",
            cause="A run without excitation tells nothing but the noise.",
            remedy="Check the logged voltage, or leave the run out.",
        )
        return
    rest = start - float(run.drive.time[0])
    if rest < 0.05:  # shorter than two frames of a camera at 30 fps
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"no rest at the start: the first command comes after {rest * 1e3:.3g} ms",
            cause="That the run starts at rest can't be seen, nor where it starts.",
            remedy="Log at least 0.1 s before the first command.",
        )
    yield from _early_motion(run, campaign, start)


def _early_motion(run: Run, campaign: Campaign, start: float) -> Iterator[Note]:
    still = run.drive.time <= start
    travel = float(np.ptp(run.drive.angle[still], axis=0).max())
    tolerance = 8 * campaign.sensors.encoder_sigma  # noise spans some 6 to 8 of its sigma
    if campaign.counts_per_rev is not None:
        tolerance = max(tolerance, 2 * encoder_resolution(campaign.counts_per_rev))
    if travel > tolerance:
        yield _moves_early(run, DRIVE_FILE, f"a pulley turns by {travel * 1e3:.3g} mrad", start)
    if run.camera is None or run.clock_offset is None:
        return
    still = run.camera.time - run.clock_offset <= start
    travel = _span(run.camera.pose[still])
    if travel > 8 * campaign.sensors.camera_position_sigma:
        yield _moves_early(
            run, CAMERA_FILE, f"the end-effector moves by {travel * 1e3:.3g} mm", start
        )


def _span(positions: Float64[np.ndarray, "rows columns"]) -> float:
    """Largest difference inside a column, 0 where nothing was seen."""
    seen = [column[~np.isnan(column)] for column in positions.T]
    return max((float(np.ptp(column)) for column in seen if column.size), default=0.0)


def _moves_early(run: Run, file: str, motion: str, start: float) -> Note:
    return Note(
        file=f"{run.name}/{file}",
        what=f"moves before anything is commanded: {motion} before t = {start:.4g} s",
        cause="An amplifier's offset, a start that wasn't at rest, or clocks that disagree.",
        remedy="Trim the amplifier, wait for standstill, check clock_offset and [knock].",
    )


DRIVE_OBSERVATIONS: tuple[Observation, ...] = (
    _extra_columns,
    _sampling,
    _voltage_limit,
    _encoder,
    _knock,
    _rest,
)
"""Everything that is looked at, in the order in which it is told."""
