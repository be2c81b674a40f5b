"""What a run's camera is worth noting for."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from identification.campaign.notes.note import Note, Observation, rig_value, share
from identification.campaign.read import RUN_FILE
from identification.campaign.streams import CAMERA_FILE
from identification.campaign.types import Campaign, Run


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
            what=f"{share(~inside)} of the frames are outside the drive's time, "
            f"{camera[0]:.4g} to {camera[-1]:.4g} s against "
            f"{drive[0]:.4g} to {drive[-1]:.4g} s",
            cause="The clocks differ by more than the stated offset.",
            remedy='State `clock_offset` in [camera], or write "unknown".',
        )


def _pose(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.camera is None:
        return
    size = [rig_value(name, campaign) for name in ("frame_width", "frame_height")]
    position = run.camera.pose
    outside = ((position < 0) | (position > np.array(size))).any(axis=1)
    if outside.any():
        yield Note(
            file=f"{run.name}/{CAMERA_FILE}",
            what=f"the end-effector is outside the frame of {size[0]:.4g} m by {size[1]:.4g} m "
            f"in {share(outside)} of the frames",
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


CAMERA_OBSERVATIONS: tuple[Observation, ...] = (
    _no_camera,
    _frames,
    _markers,
    _clock,
    _pose,
)
"""Everything that is looked at, in the order in which it is told."""
