"""Levenberg–Marquardt from several starts at once, with lower bounds."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

Evaluate = Callable[
    [Float[np.ndarray, "starts parameters"]],
    tuple[Float[np.ndarray, "starts samples"], Float[np.ndarray, "starts samples parameters"]],
]
"""Residuals and their Jacobian for a batch of parameters."""


class Minimum(NamedTuple):
    """The best of the minima that the starts led to."""

    parameters: Float[np.ndarray, " parameters"]
    """Parameters at the minimum."""
    residuals: Float[np.ndarray, " samples"]
    """Residuals there."""
    jacobian: Float[np.ndarray, "samples parameters"]
    """Their derivatives there."""
    costs: Float[np.ndarray, " starts"]
    """Half the sum of squares at the end of each start."""
    iterations: int
    """Steps tried."""


def minimise(
    evaluate: Evaluate,
    starts: Float[np.ndarray, "starts parameters"],
    *,
    lower: Float[np.ndarray, " parameters"],
    max_iterations: int = 20,
    tolerance: float = 1e-10,
) -> Minimum:
    r"""Minimise half the sum of squared residuals from every start, and take the best.

    $$ (J_F^T J_F + \lambda\, \mathrm{diag}\, J_F^T J_F)\, \delta_F = -J_F^T r $$

    over the free set $F$: parameters at their bound whose gradient pushes outwards rest.
    All starts go on together, because the evaluation is batched. Where the residuals have
    kinks it comes near a minimum and stalls there: `identification.axis.pattern_search.polish`
    goes the rest of the way.

    Args:
        evaluate: Residuals and Jacobian of a batch of parameters.
        starts: Where to start, one row each, within the bounds.
        lower: Lower bounds, -inf for none.
        max_iterations: Largest number of evaluations after the first.
        tolerance: A start is at rest when the linear model promises to lower its cost by
            less than this share; 1e-10 moves no parameter by 1e-4 of its white-noise
            standard error in a record of less than 1e6 samples.

    Returns:
        The best minimum.

    Raises:
        ValueError: If the residuals are finite at no start.
    """
    x = np.maximum(starts, lower)
    residuals, jacobian = evaluate(x)
    cost = _costs(residuals, jacobian)
    if not np.any(np.isfinite(cost)):
        raise ValueError(
            f"the residuals are finite at none of the {len(starts)} starts, expected a finite "
            f"simulation at one of them at least. Starts: {starts.tolist()}."
        )
    damping, growth = np.full(len(x), 1e-3), np.full(len(x), 2.0)
    rest = ~np.isfinite(cost)
    iterations = 0
    while iterations < max_iterations and not np.all(rest):
        step, promise = _steps(x, residuals, jacobian, damping=damping, lower=lower, rest=rest)
        rest = rest | (promise <= tolerance * cost)
        trial = np.maximum(x + np.where(rest[:, None], 0.0, step), lower)
        new_residuals, new_jacobian = evaluate(trial)
        new_cost = _costs(new_residuals, new_jacobian)
        better = ~rest & (new_cost < cost)
        x = np.where(better[:, None], trial, x)
        residuals = np.where(better[:, None], new_residuals, residuals)
        jacobian = np.where(better[:, None, None], new_jacobian, jacobian)
        cost = np.where(better, new_cost, cost)
        damping = np.where(better, damping / 10, damping * growth)
        growth = np.where(better, 2.0, growth * 2)
        # A step this short leads nowhere: rounding, or a kink to be left to `polish`.
        rest = rest | (damping > 1e8)
        iterations += 1
    best = int(np.nanargmin(np.where(np.isfinite(cost), cost, np.nan)))
    return Minimum(
        parameters=x[best],
        residuals=residuals[best],
        jacobian=jacobian[best],
        costs=cost,
        iterations=iterations,
    )


def _costs(
    residuals: Float[np.ndarray, "starts samples"],
    jacobian: Float[np.ndarray, "starts samples parameters"],
) -> Float[np.ndarray, " starts"]:
    """Half the sum of squares of each start, infinite where anything isn't finite."""
    finite = np.all(np.isfinite(residuals), axis=1) & np.all(np.isfinite(jacobian), axis=(1, 2))
    cost = 0.5 * np.sum(np.where(finite[:, None], residuals, 0.0) ** 2, axis=1)
    return np.where(finite, cost, np.inf)


def _steps(
    x: Float[np.ndarray, "starts parameters"],
    residuals: Float[np.ndarray, "starts samples"],
    jacobian: Float[np.ndarray, "starts samples parameters"],
    *,
    damping: Float[np.ndarray, " starts"],
    lower: Float[np.ndarray, " parameters"],
    rest: Bool[np.ndarray, " starts"],
) -> tuple[Float[np.ndarray, "starts parameters"], Float[np.ndarray, " starts"]]:
    """Each start's damped step, and how much the undamped linear model would gain."""
    steps, promises = np.zeros_like(x), np.zeros(len(x))
    for i in np.flatnonzero(~rest):
        gradient = jacobian[i].T @ residuals[i]
        free = ~((x[i] <= lower) & (gradient > 0))
        normal = jacobian[i].T @ jacobian[i]
        scale = np.sqrt(np.diag(normal))
        free &= scale > 0
        unit = normal[np.ix_(free, free)] / np.outer(scale[free], scale[free])
        right = gradient[free] / scale[free]
        damped = unit + damping[i] * np.eye(len(unit))
        steps[i, free] = -np.linalg.solve(damped, right) / scale[free]
        # The gain of a barely damped step: rank-deficient problems stay finite.
        promises[i] = 0.5 * right @ np.linalg.solve(unit + 1e-9 * np.eye(len(unit)), right)
    return steps, promises
