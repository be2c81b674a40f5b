"""The last part of the way to a minimum that lies on a kink: search without a gradient."""

import dataclasses
from collections.abc import Callable

import numpy as np
from jaxtyping import Float

Evaluate = Callable[
    [Float[np.ndarray, "starts parameters"]],
    tuple[Float[np.ndarray, "starts samples"], Float[np.ndarray, "starts samples parameters"]],
]
"""Residuals and their Jacobian for a batch of parameters."""

_WIDEST = 0.3  # of the residuals' norm: a first step worth 4 % of the root mean square
_NARROWEST = 0.02  # white-noise standard errors: a hundredth of an interval's width
_REFRESH = 10  # steps between looks at the Jacobian: the metric changes little on the way
_SEED = 0  # the directions are random, the result is not


@dataclasses.dataclass(frozen=True, eq=False)
class Polished:
    """A minimum that no step in any direction improves noticeably."""

    parameters: Float[np.ndarray, " parameters"]
    """Parameters at the minimum."""
    residuals: Float[np.ndarray, " samples"]
    """Residuals there."""
    jacobian: Float[np.ndarray, "samples parameters"]
    """Their derivatives there, of one side of a kink."""
    iterations: int
    """Sets of directions tried."""
    converged: bool
    """Whether the steps became as short as 2 % of a white-noise standard error."""


def polish(
    evaluate: Evaluate,
    costs: Callable[[Float[np.ndarray, "points parameters"]], Float[np.ndarray, " points"]],
    start: Float[np.ndarray, " parameters"],
    *,
    lower: Float[np.ndarray, " parameters"],
    max_iterations: int = 200,
) -> Polished:
    """Walk down along random orthogonal directions until short steps don't help either.

    Where a sum of squares has kinks, gradients of one side lead across the kink and
    gradient methods stall beside it. Here each iteration tries both ways along a fresh
    random basis, in coordinates in which the smooth part is round, and takes the best; the
    step doubles where it helps and halves where it doesn't.

    Args:
        evaluate: Residuals and Jacobian of a batch of parameters.
        costs: Half the sums of squared residuals of a batch of parameters.
        start: Where to start, within the bounds.
        lower: Lower bounds, -inf for none.
        max_iterations: Largest number of sets of directions.

    Returns:
        The minimum.

    Reference:
        C. Audet, J. Dennis, "Mesh adaptive direct search algorithms for constrained
        optimization", SIAM Journal on Optimization 17(1), 2006: why the directions change.
    """
    random = np.random.default_rng(_SEED)
    x, count = start, len(start)
    cost, samples, metric = _look(evaluate, x)
    radius, iterations = _WIDEST, 0
    narrowest = _NARROWEST / np.sqrt(samples)
    while radius > narrowest and iterations < max_iterations:
        basis, _ = np.linalg.qr(random.normal(size=(count, count)))
        steps = np.concatenate([basis, -basis]) @ metric.T
        trials = np.maximum(x + radius * np.sqrt(2 * cost) * steps, lower)
        merits = costs(trials)
        best = int(np.argmin(np.where(np.isfinite(merits), merits, np.inf)))
        if merits[best] < cost:
            x, cost, radius = trials[best], float(merits[best]), min(2 * radius, _WIDEST)
        else:
            radius /= 2
        iterations += 1
        if iterations % _REFRESH == 0:
            _, _, metric = _look(evaluate, x)
    residuals, jacobian = evaluate(x[None])
    return Polished(x, residuals[0], jacobian[0], iterations, bool(radius <= narrowest))


def _look(
    evaluate: Evaluate, x: Float[np.ndarray, " parameters"]
) -> tuple[float, int, Float[np.ndarray, "parameters parameters"]]:
    """Cost, number of residuals, and the steps [columns] that change them by a norm of 1."""
    residuals, jacobian = evaluate(x[None])
    scale = np.linalg.norm(jacobian[0], axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh((jacobian[0] / scale).T @ (jacobian[0] / scale))
    # What hardly changes the residuals is walked along in steps of at most 1e4 scales.
    floor = 1e-8 * max(float(values[-1]), 1.0)
    metric = vectors / np.sqrt(np.maximum(values, floor)) / scale[:, None]
    return 0.5 * float(residuals[0] @ residuals[0]), residuals.shape[1], metric
