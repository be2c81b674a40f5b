"""What a run's camera is worth noting for.

What it says of the encoders, and frames that can't be, `doctor` tells.
"""

from collections.abc import Iterator

import numpy as np

from identification.campaign.notes.drive import excitation_start
from identification.campaign.notes.note import Note, Observation, early_motion, rig_value, share
from identification.campaign.read import RUN_FILE
from identification.campaign.streams import CAMERA_FILE, POSITIONS
from identification.campaign.types import Campaign, Run

GAP = 6.2
"""Frame periods without a frame from which on the doctor tells; a dropout of six is common."""

PLACED = 0.012
"""Distance of the camera's start from [initial] [m] from which on the doctor contradicts."""

STRAY = 0.09
"""Share of the frames outside the frame from which on the doctor contradicts."""


def _dropped_frames(run: Run, campaign: Campaign) -> Iterator[Note]:
    time = run.camera.time
    steps = np.diff(time)
    period = float(np.median(steps))
    # From 1.5 on it is nearer to two periods than to a single one.
    gaps = (steps > 1.5 * period) & (steps <= GAP * period)
    if gaps.any():
        lost = int(np.sum(np.rint(steps[gaps] / period) - 1))
        worst = int(np.argmax(np.where(gaps, steps, 0.0)))
        yield Note(
            what=f"{lost} frames dropped in {int(gaps.sum())} gaps, the longest of "
            f"{steps[worst] * 1e3:.4g} ms at t = {time[worst]:.4g} s",
            cause="The vision system didn't keep up, or lost the frame.",
            remedy="Nothing to do for a few; for many, lower the frame rate.",
        )


def _lost_markers(run: Run, campaign: Campaign) -> Iterator[Note]:
    lost = np.isnan(run.camera.position)
    if lost.any():
        counts = zip(POSITIONS, lost.sum(axis=0).tolist(), strict=True)
        each = [f"{name} in {count} of {len(lost)} frames" for name, count in counts if count]
        yield Note(
            what=f"markers lost: {', '.join(each)}",
            cause="Empty cells; the fit goes without them.",
            remedy="For many, check the light and what hides the marker.",
        )


def _unknown_clock(run: Run, campaign: Campaign) -> Iterator[Note]:
    if run.clock_offset is None:
        yield Note(
            what='the camera\'s clock offset is "unknown"',
            cause="The fit estimates it, at some cost in certainty.",
            remedy="Trigger both streams together, and state the offset.",
        )


def _outside(run: Run, campaign: Campaign) -> Iterator[Note]:
    size = [rig_value(name, campaign) for name in ("frame_width", "frame_height")]
    position = run.camera.pose
    outside = ((position < 0) | (position > np.array(size))).any(axis=1)
    if 0 < outside.mean() <= STRAY:
        yield Note(
            what=f"the end-effector is outside the frame of {size[0]:.4g} m by {size[1]:.4g} m "
            f"in {share(outside)} of the frames",
            cause="A wrong unit in the header, another origin, or another frame.",
            remedy="Check the units and the origin, or set the frame's size in [robot].",
        )


def _placement(run: Run, campaign: Campaign) -> Iterator[Note]:
    position = run.camera.pose
    seen = position[~np.isnan(position).any(axis=1)]
    if run.initial is None or not seen.size:
        return
    nominal = np.array([run.initial.x_e, run.initial.y_e])
    distance = float(np.abs(seen[0] - nominal).max())
    if 5 * run.initial.placement_sigma < distance <= PLACED:
        yield Note(
            what=f"[initial] is {distance * 1e3:.4g} mm off what the camera sees first, "
            f"with a placement_sigma of {run.initial.placement_sigma * 1e3:.3g} mm",
            cause="A slip in the note, a wrong unit, or a placement that was rougher.",
            remedy="Correct [initial], or raise its placement_sigma.",
        )


def _early_motion(run: Run, campaign: Campaign) -> Iterator[Note]:
    start = excitation_start(run)
    if start is None or run.clock_offset is None:
        return
    still = run.camera.pose[run.camera.time - run.clock_offset <= start]
    seen = [column[~np.isnan(column)] for column in still.T]
    travel = max((float(np.ptp(column)) for column in seen if column.size), default=0.0)
    if travel > 8 * campaign.sensors.of_camera(run)[[0, 4]].max():
        yield early_motion(f"the end-effector moves by {travel * 1e3:.3g} mm", start)


CAMERA_OBSERVATIONS: tuple[tuple[str, Observation], ...] = (
    (CAMERA_FILE, _dropped_frames),
    (CAMERA_FILE, _lost_markers),
    (RUN_FILE, _unknown_clock),
    (CAMERA_FILE, _outside),
    (RUN_FILE, _placement),
    (CAMERA_FILE, _early_motion),
)
"""What is looked at where there is a camera, in the order of the notes, with the file that it
is about."""
