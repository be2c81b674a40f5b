"""Where a fit begins: clocks and start poses from the logs, the rest by a scan.

The vibration's phase wraps, so a fit that starts at the wrong pretension ends in a local
minimum. A scan over pretension and friction force on a coarse grid finds the valleys; a
cost that counts the logarithm of every channel's misfit keeps one diverging encoder from
deciding alone.
"""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.accumulate import run_residuals
from identification.campaign.types import Run
from identification.record import Record

LANES = 240
"""Simulations side by side; a fixed number, so that one compilation serves every scan."""

PRETENSIONS = tuple(float(t) for t in 15 * 1.05 ** np.arange(80))
"""Effective pretensions to try [N]: 5 % apart, as far as the phase of a few periods goes."""

FRICTION_FORCES = tuple(float(f) for f in 0.5 * 1.4 ** np.arange(12))
"""Friction forces of a carriage to try, 4Tμ [N]."""

KNOCKS = tuple(float(f) for s in (-1, 1) for f in s * 2.0 * 1.25 ** np.arange(20))
"""Forces of a knock to try [N]."""


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
    for seen, moved in ((run.camera.position[:, 2], carriage), (run.camera.position[:, 4], height)):
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


def _refine(function, grid: Float[np.ndarray, " n"]) -> float:
    """Minimum of a function of one variable: the grid's best, then ever finer grids."""
    for _ in range(4):
        best = grid[np.argmin([function(point) for point in grid])]
        spacing = (grid[1] - grid[0]) / 5
        grid = best + spacing * np.arange(-5, 6)
    return float(best)


def start_pose(run: Run, offset: float) -> Float[np.ndarray, "3"]:
    """Start of the lower carriage, the upper carriage and the height.

    Args:
        run: The run.
        offset: Camera time minus drive time [s].

    Returns:
        Medians of the camera's frames before anything moves [m]; the nominal start
        where there are none.

    Raises:
        ValueError: If the run has neither a camera nor a nominal start.
    """
    if run.camera is None:
        if run.initial is None:
            raise ValueError(
                f"run {run.name!r}: where it started is unknown, got neither a camera nor "
                "`[initial]`, expected at least one [m]. Add the start to `run.toml`, or "
                "leave the run out."
            )
        return np.array([run.initial.x_e, run.initial.x_e, run.initial.y_e])
    stamps = run.camera.time - offset
    before = stamps <= rest_until(run)
    if not np.any(before & np.all(np.isfinite(run.camera.position), axis=1)):
        before = stamps <= np.sort(stamps)[: min(5, stamps.size)][-1]
    columns = run.camera.position[:, [2, 3, 4]]
    pose = np.array([_median(columns[before, k], columns[:, k]) for k in range(3)])
    if run.initial is not None and not np.all(np.isfinite(pose)):
        nominal = np.array([run.initial.x_e, run.initial.x_e, run.initial.y_e])
        pose = np.where(np.isfinite(pose), pose, nominal)
    return pose


def rest_until(run: Run) -> float:
    """When a run may begin to move: its first command or its knock [s].

    Args:
        run: The run.

    Returns:
        Drive time up to which it is at rest [s].
    """
    commanded = np.flatnonzero(np.any(run.drive.voltage != 0, axis=1))
    first = run.drive.time[commanded[0]] if commanded.size else run.drive.time[-1]
    return float(min(first, run.knock.start if run.knock is not None else np.inf))


def _median(early: Float[np.ndarray, " n"], every: Float[np.ndarray, " m"]) -> float:
    for sample in (early, every):
        valid = sample[np.isfinite(sample)]
        if valid.size:
            return float(np.median(valid))
    return float("nan")


@eqx.filter_jit
def log_costs(
    robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "lanes n"],
    run: Int[Array, " lanes"],
    records: Record,
) -> Float[Array, " lanes"]:
    r"""Misfit of many simulations, $\sum_c n_c \ln(\overline{r_c^2} + 1)$ over the channels.

    That is the likelihood of noise whose size is unknown in every channel $c$.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: Free quantities and circumstances of each simulation.
        run: Which run each of them is of.
        records: The runs.

    Returns:
        The misfits; infinite where a simulation diverged.
    """

    def one(unknown: Float[Array, " n"], number: Int[Array, ""]) -> Float[Array, ""]:
        chosen = jax.tree.map(lambda leaf: leaf[number], records)
        found = run_residuals(robot, free, unknown, chosen)
        rows = jnp.sum(chosen.angle_weight > 0)
        frames = jnp.sum(chosen.frame_weight > 0, axis=0)
        angle = jnp.sum(jnp.square(found.angle), axis=0)
        frame = jnp.sum(jnp.square(found.frame), axis=0)
        misfit = jnp.sum(rows * jnp.log1p(angle / rows))
        misfit += jnp.sum(frames * jnp.log1p(frame / jnp.maximum(frames, 1)))
        return jnp.where(jnp.isfinite(misfit), misfit, jnp.inf)

    lanes = jax.tree.map(
        lambda leaf: leaf.reshape(-1, LANES, *leaf.shape[1:]), (unknowns, run)
    )
    return jax.lax.map(lambda lane: jax.vmap(one)(*lane), lanes).reshape(-1)


def scan(
    robot, free: tuple[str, ...], unknowns: np.ndarray, run: Sequence[int], records: Record
) -> Float[np.ndarray, " lanes"]:
    """Misfits of any number of simulations, padded to whole chunks.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: Free quantities and circumstances of each simulation.
        run: Which run each of them is of.
        records: The runs.

    Returns:
        The misfits.
    """
    count = len(run)
    padding = -count % LANES
    unknowns = np.concatenate([unknowns, np.repeat(unknowns[:1], padding, axis=0)])
    numbers = np.concatenate([np.asarray(run), np.repeat(run[0], padding)])
    found = log_costs(robot, free, jnp.asarray(unknowns), jnp.asarray(numbers), records)
    return np.asarray(found)[:count]
