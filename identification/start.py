"""Clocks and start poses of runs, from the logs alone."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Run, Sensors

CLOCK_MARGIN = 0.02
"""How far an estimated clock may still move [s]: as far as the fit may trust no frame."""

STILL = 1e-3
"""Turn of a driver pulley that counts as standing still [rad]: less than 0.1 mm of cable."""

TILT_SIGMA = 0.02
"""Standard deviation of the slope at which friction may leave the carriages [1].

A slope of up to the coefficient of friction can be held. Only a run without a camera
depends on it.
"""


class Start(NamedTuple):
    """What is known of where a run starts."""

    position: Float[np.ndarray, "3"]
    """Lower carriage, upper carriage and height [m]."""
    sigma: Float[np.ndarray, "3"]
    """Their standard deviations [m]."""
    until: float
    """Drive time since its first row up to which camera frames went into it [s]."""


def start_pose(run: Run, offset: float, sensors: Sensors, height: float) -> Start:
    """Start of a run: from the camera while nothing moves, else as it was noted.

    Args:
        run: The run.
        offset: Camera time minus drive time, as far as it is known [s].
        sensors: The sensors' noise.
        height: Height of the frame [m].

    Returns:
        Start and its standard deviations.

    Raises:
        ValueError: If nothing tells where the run started.
    """
    seen = _seen_at_rest(run, offset, sensors)
    if seen is not None:
        return seen
    if run.initial is None:
        raise ValueError(
            f"run {run.name!r}: where it started is unknown, got neither camera frames before "
            "it moves nor `[initial]`, expected at least one [m]. Add `[initial]` to its "
            "run.toml, or leave the run out."
        )
    x, y, placed = run.initial.x_e, run.initial.y_e, run.initial.placement_sigma
    aside = np.hypot(placed, TILT_SIGMA * height / 2)
    return Start(np.array([x, x, y]), np.array([aside, aside, placed]), -np.inf)


def rest_until(run: Run) -> float:
    """Until when a run rests: its knock, or the drives' first visible motion.

    A controller may chatter by a count before anything moves, so the first command tells
    nothing.

    Args:
        run: The run.

    Returns:
        Drive time up to which it is at rest [s].
    """
    turned = np.max(np.abs(run.drive.angle - run.drive.angle[0]), axis=1)
    moved = np.flatnonzero(turned > STILL)
    first = run.drive.time[moved[0]] if moved.size else run.drive.time[-1]
    return float(min(first, run.knock.start if run.knock is not None else np.inf))


def _seen_at_rest(run: Run, offset: float, sensors: Sensors) -> Start | None:
    if run.camera is None:
        return None
    margin = CLOCK_MARGIN if run.clock_offset is None else 0.0
    resting = run.camera.time - offset <= rest_until(run) - margin
    frames = run.camera.position[resting][:, [2, 3, 4]]
    count = np.count_nonzero(np.isfinite(frames), axis=0)
    if np.any(count == 0):
        return None
    return Start(
        np.nanmean(frames, axis=0),
        sensors.camera_position_sigma / np.sqrt(count),
        rest_until(run) - margin - run.drive.time[0],
    )


def clock_offset(run: Run, effective_radius: float) -> float:
    """Camera time minus drive time, from what both streams see of the same motion.

    The lower carriage and the height follow the encoders without any dynamics, so the
    offset at which the camera agrees with them best needs no model.

    Args:
        run: A run with a camera.
        effective_radius: Effective radius of the driver pulleys [m].

    Returns:
        The offset [s]; 0 where the run moves too little to tell.
    """
    time, angle = run.drive.time, run.drive.angle
    carriage = effective_radius * (angle[:, 0] + angle[:, 1]) / 2
    height = effective_radius * (angle[:, 0] - angle[:, 1]) / 2
    pairs = []
    for seen, moved in (
        (run.camera.position[:, 2], carriage),
        (run.camera.position[:, 4], height),
    ):
        valid = np.isfinite(seen)
        # Ten times the camera's noise of 0.2 mm: below it, there is nothing to align.
        if np.ptp(moved) > 2e-3 and np.count_nonzero(valid) > 5:
            pairs.append((run.camera.time[valid], seen[valid], moved))
    if not pairs:
        return 0.0

    def mismatch(offset: float) -> float:
        total = 0.0
        for stamps, seen, moved in pairs:
            inside = (stamps - offset > time[0]) & (stamps - offset < time[-1])
            difference = seen[inside] - np.interp(stamps[inside] - offset, time, moved)
            total += float(np.mean(np.square(difference - np.mean(difference))))
        return total

    return float(_refine(mismatch, np.arange(-0.5, 0.5001, 0.01)))


def _refine(function: Callable[[float], float], grid: Float[np.ndarray, " n"]) -> float:
    """Minimum of a function of one variable: the grid's best, then ever finer grids."""
    for _ in range(4):
        best = grid[np.argmin([function(point) for point in grid])]
        spacing = (grid[1] - grid[0]) / 5
        grid = best + spacing * np.arange(-5, 6)
    return float(best)
