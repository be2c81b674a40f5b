r"""Levenberg and Marquardt's method for the worst of many sums of squares.

What falls is the conditional value at risk of the models' costs, the mean of the worst share
$\beta$ of them:

$$ \mathrm{CVaR}_\beta(c) = \frac{1}{m} \sum_{i \le m} c_{(i)}, \qquad
   c_i = |r_i|^2, \quad m = \lceil \beta n \rceil $$

Its gradient is that of the tail alone, so that only the tail's Jacobians are needed, and
near a point where the tail changes it is as smooth as the models are many.

Reference: R. T. Rockafellar, S. Uryasev, "Optimization of conditional value-at-risk",
J. Risk 2(3), 2000, doi:10.21314/JOR.2000.038.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

_FIRST_DAMPING = 1e-2
_RAISES = 6
"""Dampings that are tried before a point counts as a minimum, or as a kink."""

Costs = Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, " models"]]
"""From a point to every model's cost."""
Linearised = Callable[
    [Float[np.ndarray, " n"], Int[np.ndarray, " tail"]],
    tuple[Float[np.ndarray, "tail residuals"], Float[np.ndarray, "tail residuals n"]],
]
"""From a point and some of the models to their residuals and Jacobians."""


class Descent(NamedTuple):
    """Where a descent ended."""

    point: Float[np.ndarray, " n"]
    """The point."""
    value: float
    """Mean cost of the tail there [1]."""
    history: tuple[float, ...]
    """That mean at the start and after each step [1]."""


def tail_of(costs: Float[np.ndarray, " models"], share: float) -> Int[np.ndarray, " tail"]:
    """The worst models.

    Args:
        costs: Their costs; what isn't a number is worse than any.
        share: Share of the models that counts, above 0 [1].

    Returns:
        Their indices, the worst last.
    """
    count = max(math.ceil(share * len(costs) - 1e-9), 1)
    return np.argsort(np.nan_to_num(costs, nan=np.inf), kind="stable")[-count:]


def value_at_risk(costs: Float[np.ndarray, " models"], share: float) -> float:
    """Mean of the worst share, the conditional value at risk.

    Args:
        costs: Costs of the models [any unit].
        share: Share of the models that counts, above 0 [1].

    Returns:
        Their mean [the costs' unit]; not finite where one of them isn't.
    """
    return float(np.mean(costs[tail_of(costs, share)]))


def descend(
    costs: Costs,
    linearised: Linearised,
    point: Float[np.ndarray, " n"],
    *,
    share: float,
    iterations: int,
    tolerance: float = 5e-3,
    progress: Callable[[float], None] = lambda share: None,
) -> Descent:
    """A point from which the tail's mean no longer falls.

    Args:
        costs: Costs of all models.
        linearised: Residuals and Jacobians of some.
        point: Where to start.
        share: Share of the models that counts, above 0 [1].
        iterations: Steps at the most.
        tolerance: Share of the tail's mean that a step has to save to go on [1].
        progress: Told which share of the steps has been taken.

    Returns:
        The best point seen, the start at the worst.
    """
    each, damping = costs(point), _FIRST_DAMPING
    history = [value_at_risk(each, share)]
    for iteration in range(iterations):
        progress(iteration / iterations)
        residuals, jacobian = linearised(point, tail_of(each, share))
        normal = np.einsum("ija,ijb->ab", jacobian, jacobian) / len(residuals)
        slope = np.einsum("ija,ij->a", jacobian, residuals) / len(residuals)
        # A direction that moves nothing keeps a little damping of its own.
        scale = np.diag(normal) + 1e-6 * np.trace(normal)
        for _ in range(_RAISES):
            tried = point - np.linalg.solve(normal + damping * np.diag(scale), slope)
            found = costs(tried)
            least = value_at_risk(found, share)
            if least < history[-1]:
                break
            damping *= 6
        else:
            break
        saved = history[-1] - least
        point, each, damping = tried, found, max(damping / 4, 1e-6)
        history.append(least)
        if saved < tolerance * least:
            break
    return Descent(point, history[-1], tuple(history))
