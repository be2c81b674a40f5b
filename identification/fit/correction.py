"""Deferred correction: what the coarser grid errs by is taken off the measurements.

A fit on the coarser grid ends where that grid's simulation meets the logs, some of the engine's
error off. The exact simulation at that point says by how much, and hardly changes from there
on. With the difference taken off the measurements the coarser grid has its minimum where the
exact one has it, and the Jacobians, which only lead the way, stay cheap.
"""

import dataclasses

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Float

from identification.data.record import windowed
from identification.fit.problem import Problem


def corrected(problem: Problem, point: Float[np.ndarray, " n"]) -> Problem:
    """The problem whose coarser grid has no error of its own about a point.

    Args:
        problem: The problem.
        point: Vector of the fit.

    Returns:
        The problem with corrected measurements on the coarser grid.
    """
    logs = problem.logs
    if logs.records is None:
        return problem
    residuals = problem.cabled_sums([point], range(len(logs.cabled))).residuals
    _, angle, frame = problem.predictions(point)
    weight = np.square(logs.records.angle_weight)
    difference = windowed(weight * (logs.records.angle - np.asarray(angle)), logs.factor)
    information = np.square(logs.rough.angle_weight)
    exact = difference / np.where(information > 0, information, 1.0)
    turned = exact - unweighted(residuals.angle, logs.rough.angle_weight)
    seen = logs.rough.frame_weight > 0
    moved = np.where(seen, logs.rough.frame - np.asarray(frame), 0.0) - unweighted(
        residuals.frame, logs.rough.frame_weight
    )
    rough = eqx.tree_at(
        lambda r: (r.angle, r.frame),
        logs.rough,
        (logs.rough.angle + turned, logs.rough.frame + moved),
    )
    return dataclasses.replace(problem, logs=dataclasses.replace(logs, rough=rough))


def unweighted(
    residual: Float[np.ndarray, "..."], weight: Float[jax.Array | np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """Residuals in the measurement's own unit; 0 where nothing was measured."""
    weight = np.asarray(weight)
    return np.where(weight > 0, residual / np.where(weight > 0, weight, 1.0), 0.0)
