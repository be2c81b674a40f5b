r"""Four-parameter fits of very many short runs in one batch, on the linear engine.

Friction force $4T\mu$, drive inertia and damping, and effective pretension, of one run near
one height each. All runs of a batch have one grid; every run is a lane of its own, and a lane
that fails is a row with its reason, never a lost batch.

A start is put right in three stages: the momentum of the whole robot tells the drives and
the friction force, whatever the loop does inside of it; a scan over the pretension then finds
the valley of the vibration's phase; and all channels together end in it. Lanes that aren't
there yet go on among themselves.
"""

import dataclasses

import jax
import numpy as np
from jaxtyping import Float, Int

from identification.many.lanes import Batch, Lanes, followed, is_minimum, unfinished
from identification.many.lanes import ShortRuns as ShortRuns
from identification.many.starts import balanced, scanned
from scdpr_jax.robot.parameters import Robot

NAMES = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
"""What is fitted, in the order of the results."""

AGAIN = (0.5, 2.0, 0.25, 4.0)
"""Multiples of the start's friction force with which a lane that isn't at its minimum begins
anew [1]: with another friction another valley of the vibration's phase fits best."""


@dataclasses.dataclass(frozen=True, eq=False)
class ManyEstimates:
    """Fits of many runs, one a row."""

    values: Float[np.ndarray, "runs 4"]
    """Fitted values in the order of `NAMES` [1, kg m², N m s, N]."""
    sigma: Float[np.ndarray, "runs 4"]
    """Standard errors by the noise alone."""
    chi_square: Float[np.ndarray, " runs"]
    """Mean squared residual [1]."""
    iterations: np.ndarray
    """Steps of the last stage."""
    failure: tuple[str, ...]
    """Why a row isn't to be used; empty where it is."""

    @property
    def converged(self) -> np.ndarray:
        """Which rows may be used."""
        return np.array([not reason for reason in self.failure])


def estimate_many(
    robot: Robot,
    runs: ShortRuns,
    starts: Float[np.ndarray, "runs 4"],
    *,
    interval: float,
    steps: int = 24,
) -> ManyEstimates:
    """Fit every run by itself, all of them in one batch.

    Args:
        robot: What isn't fitted; its drives' dry friction is held.
        runs: The runs, of a rank more than one of them.
        starts: Where each search begins, in the order of `NAMES`; twice too large or too
            small is near enough.
        interval: Length of the grid's intervals [s].
        steps: Most steps of the last stage.

    Returns:
        The fits.

    Raises:
        ValueError: If a start isn't positive.
    """
    starts = np.asarray(starts, dtype=float)
    if not np.all(starts > 0):
        raise ValueError(
            f"`starts` must be positive, got {float(starts.min())} at the least: the fit holds "
            f"the logarithms of {', '.join(NAMES)}."
        )
    rubbing = bool(np.any(robot.drive.frictions != 0))
    runs = jax.tree.map(np.asarray, runs)
    batch = Batch(robot, np.asarray(interval), runs, rubbing)
    begun = batch.each(balanced, encoded(starts))
    lanes = followed(batch, batch.each(scanned, begun), steps=steps)
    measured = np.sum(runs.weight > 0, axis=(1, 2))
    for factor in AGAIN:
        rows = np.flatnonzero(~is_minimum(lanes, measured))
        if not rows.size:
            break
        some = batch.rows(rows)
        other = begun[rows] + np.log(np.array([factor, 1.0, 1.0, 1.0]))
        found = followed(some, some.each(scanned, other), steps=steps)
        better = found.cost < lanes.cost[rows]
        for whole, part in zip(*map(jax.tree.leaves, (lanes, found)), strict=True):
            whole[rows[better]] = part[better]
    return _judged(lanes, measured)


def encoded(values: Float[np.ndarray, "runs 4"]) -> Float[np.ndarray, "runs 4"]:
    """Logarithms of friction force, inertia, damping and pretension."""
    force = 4 * values[:, 3] * values[:, 0]
    return np.log(np.stack([force, values[:, 1], values[:, 2], values[:, 3]], axis=1))


def _judged(lanes: Lanes, count: Int[np.ndarray, " runs"]) -> ManyEstimates:
    """The rows, with the reasons of those that failed."""
    force, inertia, damping, pretension = np.exp(lanes.point).T
    values = np.stack([force / (4 * pretension), inertia, damping, pretension], axis=1)
    chi_square = lanes.cost / np.maximum(count, 1)
    # The friction coefficient is the force over the pretension.
    turn = np.eye(4)
    turn[0, 3] = -1.0
    sizes = np.diagonal(lanes.information, axis1=1, axis2=2)
    told = np.isfinite(lanes.cost) & np.all(sizes > 0, axis=1)
    sigma = np.full(values.shape, np.inf)
    spread = turn @ np.linalg.pinv(lanes.information[told], hermitian=True) @ turn.T
    sigma[told] = values[told] * np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    failure = []
    for row, size in enumerate(sizes):
        untold = [name for name, own in zip(NAMES, size, strict=True) if not own > 0]
        if not np.isfinite(lanes.cost[row]):
            failure.append("the simulation isn't finite at any point that was tried")
        elif untold:
            failure.append(f"nothing that was measured depends on {', '.join(untold)}")
        else:
            failure.append(unfinished(lanes, row, chi_square[row]))
    return ManyEstimates(values, sigma, chi_square, lanes.steps, tuple(failure))
