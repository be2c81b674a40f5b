"""Clocks and start poses of runs, from the logs alone."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Run, Sensors
from scdpr_jax.robot.state import HEIGHT, LOWER

CLOCK_MARGIN = 0.02
"""How far an estimated clock may still move [s]: as far as the fit may trust no frame."""

UNKNOWN_CLOCK = 0.05
"""Standard deviation of a clock that no run tells anything about [s]."""

USUAL_ARM = 0.05
"""Standard deviation of the height at which a knock misses the centre of mass [m]."""

USUAL_DRIFT = 1e-3
"""Standard deviation of the drift of a camera's clock that may drift [1]: a quartz's is a
tenth of it, stamps that a busy computer makes are worse."""

STILL = 1e-3
"""Turn of a driver pulley that counts as standing still [rad]: less than 0.1 mm of cable."""

TILT_SIGMA = 0.02
"""Standard deviation of the slope at which friction may leave the carriages [1].

A slope of up to the coefficient of friction can be held. Only a run without a camera
depends on it.
"""


@dataclasses.dataclass(frozen=True, eq=False)
class Known:
    """Numbers with what is known of them."""

    value: Float[np.ndarray, " n"]
    """The numbers [SI]."""
    sigma: Float[np.ndarray, " n"]
    """Their standard deviations [SI]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Start:
    """What is known of where a run starts."""

    position: Float[np.ndarray, "3"]
    """Lower carriage, upper carriage and height [m]."""
    sigma: Float[np.ndarray, "3"]
    """Their standard deviations [m]."""
    until: float
    """Drive time since its first row up to which camera frames went into it [s]."""
    beginning: Known | None = None
    """How a run in motion begins, in the order of
    `identification.data.circumstances.BEGINNING`; None for one that begins at rest."""


def start_pose(
    run: Run, offset: float, sensors: Sensors, height: float, *, height_offset: float = 0.0
) -> Start:
    """Start of a run: from the camera while nothing moves, else as it was noted.

    Args:
        run: The run.
        offset: Camera time minus drive time, as far as it is known [s].
        sensors: The sensors' noise.
        height: Height of the frame [m].
        height_offset: Standard deviation of what all heights may be off by alike [m].

    Returns:
        Start and its standard deviations.

    Raises:
        ValueError: If nothing tells where the run started.
    """
    seen = _seen_at_rest(run, offset, sensors, height_offset)
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


def _seen_at_rest(
    run: Run, offset: float, sensors: Sensors, height_offset: float
) -> Start | None:
    if run.camera is None:
        return None
    margin = CLOCK_MARGIN if run.clock_offset is None else 0.0
    resting = run.camera.time - offset <= rest_until(run) - margin
    frames = run.camera.position[resting][:, LOWER:]
    count = np.count_nonzero(np.isfinite(frames), axis=0)
    if np.any(count == 0):
        return None
    return Start(
        np.nanmean(frames, axis=0),
        np.hypot(sensors.of_camera(run)[LOWER:] / np.sqrt(count), [0.0, 0.0, height_offset]),
        rest_until(run) - margin - run.drive.time[0],
    )


@dataclasses.dataclass(frozen=True)
class Clock:
    """What is known of the camera's clock in a run."""

    offset: float
    """Camera time minus drive time [s]."""
    sigma: float
    """Its standard deviation [s]; 0 where the log states the offset."""


def clocks(runs: Sequence[Run], sensors: Sensors, effective_radius: float) -> tuple[Clock, ...]:
    """The camera's clock in each run, from what both streams see of the same motion.

    The lower carriage and the height follow the encoders without any dynamics, so the
    offset at which the camera agrees with them best needs no model. Runs that hardly
    move learn it from the others, as far as those agree among themselves.

    Reference: R. DerSimonian, N. Laird, "Meta-analysis in clinical trials", Controlled
    Clinical Trials 7(3), 1986, doi:10.1016/0197-2456(86)90046-2.

    Args:
        runs: The runs with the cable on.
        sensors: The sensors' noise.
        effective_radius: Effective radius of the driver pulleys [m].

    Returns:
        For each run its clock; runs without a camera have offset and deviation 0.
    """
    unknown = [run for run in runs if run.camera is not None and run.clock_offset is None]
    aligned = {run.name: _aligned(run, sensors, effective_radius) for run in unknown}
    measured = [clock for clock in aligned.values() if np.isfinite(clock.sigma)]
    common = _pooled(measured)
    return tuple(
        _combined(aligned[run.name], common)
        if run.name in aligned
        else Clock(run.clock_offset or 0.0, 0.0)
        for run in runs
    )


def _aligned(run: Run, sensors: Sensors, effective_radius: float) -> Clock:
    """The clock by a single run's own motion."""
    time, angle = run.drive.time, run.drive.angle
    carriage = effective_radius * (angle[:, 0] + angle[:, 1]) / 2
    height = effective_radius * (angle[:, 0] - angle[:, 1]) / 2
    sigma = float(sensors.of_camera(run)[[LOWER, HEIGHT]].max())
    pairs = []
    for seen, moved in (
        (run.camera.position[:, LOWER], carriage),
        (run.camera.position[:, HEIGHT], height),
    ):
        valid = np.isfinite(seen)
        if np.ptp(moved) > 10 * sigma and np.count_nonzero(valid) > 5:
            pairs.append((run.camera.time[valid], seen[valid], moved))
    if not pairs:
        return Clock(0.0, np.inf)

    def differences(offset: float, around: float) -> Float[np.ndarray, " frames"]:
        parts = []
        for stamps, seen, moved in pairs:
            inside = (stamps - around > time[0]) & (stamps - around < time[-1])
            difference = seen[inside] - np.interp(stamps[inside] - offset, time, moved)
            parts.append(difference - np.mean(difference))
        return np.concatenate(parts)

    offset = _refine(lambda tried: np.mean(np.square(differences(tried, tried))))
    noise = max(float(np.std(differences(offset, offset))), sigma)
    later, earlier = (differences(offset + shift, offset) for shift in (1e-3, -1e-3))
    speed = (later - earlier) / 2e-3
    return Clock(offset, noise / np.sqrt(np.sum(np.square(speed))))


def _refine(function: Callable[[float], float]) -> float:
    """Minimum over half a second either way: a coarse grid, then ever finer ones."""
    grid = np.arange(-0.5, 0.5001, 0.01)
    for _ in range(5):
        best = grid[np.argmin([function(point) for point in grid])]
        grid = best + (grid[1] - grid[0]) / 5 * np.arange(-6, 7)
    return float(best)


def _pooled(clocks: Sequence[Clock]) -> Clock:
    """The campaign's clock, with how far a single run may be from it."""
    if not clocks:
        return Clock(0.0, np.inf)
    offsets = np.array([clock.offset for clock in clocks])
    weights = 1 / np.square([clock.sigma for clock in clocks])
    mean = float(np.sum(weights * offsets) / np.sum(weights))
    if len(clocks) == 1:
        return Clock(mean, np.inf)
    excess = np.sum(weights * np.square(offsets - mean)) - (len(clocks) - 1)
    spread = np.sum(weights) - np.sum(np.square(weights)) / np.sum(weights)
    between = max(0.0, float(excess / spread))
    weights = 1 / (1 / weights + between)
    mean = float(np.sum(weights * offsets) / np.sum(weights))
    return Clock(mean, float(np.sqrt(between + 1 / np.sum(weights))))


def _combined(aligned: Clock, common: Clock) -> Clock:
    """A run's own alignment and the campaign's clock together."""
    weights = np.array([aligned.sigma, common.sigma]) ** -2.0
    if not np.any(weights > 0):
        return Clock(common.offset, UNKNOWN_CLOCK)
    offset = (weights[0] * aligned.offset + weights[1] * common.offset) / np.sum(weights)
    return Clock(float(offset), float(min(np.sum(weights) ** -0.5, UNKNOWN_CLOCK)))
