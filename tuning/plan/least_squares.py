"""Levenberg and Marquardt's method for a few unknowns and any number of residuals."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

_FIRST_DAMPING = 1e-3
_RAISES = 8
"""Dampings that are tried before a point counts as a minimum, or as a kink."""

Linearisation = tuple[Float[np.ndarray, " m"], Float[np.ndarray, "m n"]]
"""Residuals at a point, and their Jacobian."""
Linearised = Callable[[Float[np.ndarray, " n"]], Linearisation]
"""From a point to that."""


class LeastSquares(NamedTuple):
    """Where a search ended."""

    point: Float[np.ndarray, " n"]
    """The point."""
    cost: float
    """Sum of the squared residuals there [1]."""
    iterations: int
    """Steps that were taken."""


def least_squares(
    linearised: Linearised,
    point: Float[np.ndarray, " n"],
    *,
    iterations: int,
    tolerance: float = 1e-3,
    progress: Callable[[float], None] = lambda share: None,
) -> LeastSquares:
    """A local minimum of a sum of squares.

    Args:
        linearised: Residuals and Jacobian.
        point: Where to start.
        iterations: Steps at the most.
        tolerance: Share of the cost that a step has to save for the search to go on [1].
        progress: Told which share of the steps has been taken.

    Returns:
        The best point seen.

    Reference: D. W. Marquardt, "An algorithm for least-squares estimation of nonlinear
    parameters", J. SIAM 11(2), 1963, doi:10.1137/0111030.
    """
    damping = _FIRST_DAMPING
    residuals, jacobian = linearised(point)
    cost = float(residuals @ residuals)
    for iteration in range(iterations):
        progress(iteration / iterations)
        normal, slope = jacobian.T @ jacobian, jacobian.T @ residuals
        # A direction that moves nothing keeps a little damping of its own.
        scale = np.diag(normal) + 1e-9 * np.trace(normal)
        for _ in range(_RAISES):
            tried = point - np.linalg.solve(normal + damping * np.diag(scale), slope)
            found, its_jacobian = linearised(tried)
            least = float(found @ found)
            if least < cost:
                break
            damping *= 4
        else:
            return LeastSquares(point, cost, iteration)
        saved = cost - least
        point, residuals, jacobian, cost = tried, found, its_jacobian, least
        damping = max(damping / 5, 1e-9)
        if saved < tolerance * least:
            return LeastSquares(point, cost, iteration + 1)
    return LeastSquares(point, cost, iterations)
