"""Notes on a run that can be read: what a careful colleague would see in the log.

Every observation is a function of the run that yields notes; `_OBSERVATIONS` lists them.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator

import numpy as np
from jaxtyping import Float64

from identification.campaign.read import RUN_FILE
from identification.campaign.streams import CAMERA_FILE, DRIVE_FILE
from identification.campaign.types import Campaign, Run, encoder_resolution
from scdpr_jax.prototype import PROVENANCE

_TYPICAL = {source.name: source.consistent for source in PROVENANCE}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Note:
    """Something that is worth knowing, and no fault."""

    file: str
    """The file, relative to the campaign's folder; of several, the first and how many."""
    what: str
    """What was seen, with its figures."""
    cause: str
    """What it usually comes from, or what it does to the result."""
    remedy: str
    """What can be done about it."""

    def __str__(self) -> str:
        return f"{self.file}: {self.what}. {self.cause} {self.remedy}"


def campaign_notes(campaign: Campaign) -> tuple[Note, ...]:
    """What is worth knowing of a campaign's runs.

    Args:
        campaign: The campaign.

    Returns:
        The notes, run by run; what is the same in several files is told once.
    """
    files: dict[tuple[str, str, str], list[str]] = {}
    for run in campaign.runs:
        for observe in _OBSERVATIONS:
            for note in observe(run, campaign):
                files.setdefault((note.what, note.cause, note.remedy), []).append(note.file)
    return tuple(
        Note(file=_together(names), what=what, cause=cause, remedy=remedy)
        for (what, cause, remedy), names in files.items()
    )


def _together(files: list[str]) -> str:
    return files[0] if len(files) == 1 else f"{files[0]} and {len(files) - 1} more"


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
            what=f"irregular sampling: {_share(odd)} of the steps are off the period of "
            f"{period * 1e3:.4g} ms, one of {steps[worst] * 1e3:.4g} ms at "
            f"t = {run.drive.time[worst]:.4g} s",
            cause="A gap holds the last command, which may not be what the drive was sent.",
            remedy="Log from the controller's own loop, at its own rate.",
        )


def _voltage_limit(run: Run, campaign: Campaign) -> Iterator[Note]:
    limit = campaign.robot.get("voltage_limit", _TYPICAL["voltage_limit"])
    largest = np.abs(run.drive.voltage).max(axis=1)
    # A thousandth of the limit: a logger's last digit, and half a count of 11 bits.
    beyond, clipped = largest > limit * 1.001, largest >= limit * 0.999
    stated = "of [robot]" if "voltage_limit" in campaign.robot else "of the paper's rig"
    if beyond.any():
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"voltage beyond the limit {stated}: {largest.max():.4g} V, limit "
            f"{limit:.4g} V, in {_share(beyond)} of the samples",
            cause="The command was logged before saturation, or the limit is another one.",
            remedy="Log the command after saturation, or set `voltage_limit` in [robot].",
        )
    elif clipped.any():
        yield Note(
            file=f"{run.name}/{DRIVE_FILE}",
            what=f"voltage clipped at the limit {stated}, {limit:.4g} V, in "
            f"{_share(clipped)} of the samples",
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
    travel = _span(run.camera.position[still][:, [0, 4]])
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


def _no_camera(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None and run.kind != "motor_step":
        yield Note(
            file=run.name,
            what=f"no {CAMERA_FILE}",
            cause="Without the camera, only the drive's side of this run counts.",
            remedy="Add the vision system's stream if there is one.",
        )


def _frames(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None:
        return
    time = run.camera.time
    steps = np.diff(time)
    period = float(np.median(steps))
    gaps = steps > 1.5 * period  # nearer to two periods than to one
    if gaps.any():
        lost = int(np.sum(np.rint(steps[gaps] / period) - 1))
        worst = int(np.argmax(steps))
        yield Note(
            file=f"{run.name}/{CAMERA_FILE}",
            what=f"{lost} frames dropped in {int(gaps.sum())} gaps, the longest of "
            f"{steps[worst] * 1e3:.4g} ms at t = {time[worst]:.4g} s",
            cause="The vision system didn't keep up, or lost the frame.",
            remedy="Nothing to do for a few; for many, lower the frame rate.",
        )


def _markers(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None:
        return
    lost = np.isnan(run.camera.position)
    if lost.any():
        names = ("x_e", "delta_e", "q_3", "q_4", "y_e")
        each = [
            f"{name} in {count} of {len(lost)} frames"
            for name, count in zip(names, lost.sum(axis=0).tolist(), strict=True)
            if count
        ]
        yield Note(
            file=f"{run.name}/{CAMERA_FILE}",
            what=f"markers lost: {', '.join(each)}",
            cause="Empty cells; the fit goes without them.",
            remedy="For many, check the light and what hides the marker.",
        )


def _clock(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None:
        return
    if run.clock_offset is None:
        yield Note(
            file=f"{run.name}/{RUN_FILE}",
            what='the camera\'s clock offset is "unknown"',
            cause="The fit estimates it, at some cost in certainty.",
            remedy="Trigger both streams together, and state the offset.",
        )
        return
    camera, drive = run.camera.time - run.clock_offset, run.drive.time
    inside = (camera >= drive[0]) & (camera <= drive[-1])
    if np.mean(inside) < 0.5:
        yield Note(
            file=f"{run.name}/{CAMERA_FILE}",
            what=f"{_share(~inside)} of the frames are outside the drive's time, "
            f"{camera[0]:.4g} to {camera[-1]:.4g} s against "
            f"{drive[0]:.4g} to {drive[-1]:.4g} s",
            cause="The clocks differ by more than the stated offset.",
            remedy='State `clock_offset` in [camera], or write "unknown".',
        )


def _pose(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None:
        return
    size = [
        campaign.robot.get(name, _TYPICAL[name]) for name in ("frame_width", "frame_height")
    ]
    position = run.camera.position[:, [0, 4]]
    outside = ((position < 0) | (position > np.array(size))).any(axis=1)
    if outside.any():
        yield Note(
            file=f"{run.name}/{CAMERA_FILE}",
            what=f"the end-effector is outside the frame of {size[0]:.4g} m by {size[1]:.4g} m "
            f"in {_share(outside)} of the frames",
            cause="A wrong unit in the header, another origin, or another frame.",
            remedy="Check the units and the origin, or set the frame's size in [robot].",
        )
    yield from _placement(run, position)


def _placement(run: Run, position: Float64[np.ndarray, "rows 2"]) -> Iterator[Note]:
    seen = position[~np.isnan(position).any(axis=1)]
    if run.initial is None or not seen.size:
        return
    nominal = np.array([run.initial.x_e, run.initial.y_e])
    distance = float(np.abs(seen[0] - nominal).max())
    if distance > 5 * run.initial.placement_sigma:
        yield Note(
            file=f"{run.name}/{RUN_FILE}",
            what=f"[initial] is {distance * 1e3:.4g} mm off what the camera sees first, "
            f"with a placement_sigma of {run.initial.placement_sigma * 1e3:.3g} mm",
            cause="A slip in the note, a wrong unit, or a placement that was rougher.",
            remedy="Correct [initial], or raise its placement_sigma.",
        )


def _share(flags: "np.ndarray") -> str:
    return f"{100 * float(np.mean(flags)):.2g} %"


_OBSERVATIONS: tuple[Callable[[Run, Campaign], Iterator[Note]], ...] = (
    _extra_columns,
    _sampling,
    _voltage_limit,
    _encoder,
    _knock,
    _rest,
    _no_camera,
    _frames,
    _markers,
    _clock,
    _pose,
)
