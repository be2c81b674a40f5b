r"""The worst of many sums of squares, as a merit for Levenberg and Marquardt's method.

What falls is the conditional value at risk of the models' costs, the mean of the worst share
$\beta$ of them:

$$ \mathrm{CVaR}_\beta(c) = \frac{1}{m} \sum_{i \le m} c_{(i)}, \qquad
   c_i = |r_i|^2, \quad m = \lceil \beta n \rceil $$

Its gradient is that of the tail alone, so that only the tail's Jacobians are needed, and those
only where a step goes on. Near a point where the tail changes the merit is as smooth as the
models are many. The worst model alone would be simpler to say and has a kink wherever another
one takes its place; the mean of all lets a few robots vibrate.

Reference: R. T. Rockafellar, S. Uryasev, "Optimization of conditional value-at-risk",
J. Risk 2(3), 2000, doi:10.21314/JOR.2000.038.
"""

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Int

from scdpr_jax.numerics.levenberg_marquardt import Damping, Minimum, Stopping, minimise
from scdpr_jax.numerics.merit import Merit
from scdpr_jax.numerics.progress import SILENT, Progress

_DAMPING = Damping(first=1e-2, fall=4.0, rise=6.0, least=1e-6, floor=1e-6)
"""Damping of a descent; the floor is for unknowns that move almost nothing."""
_REJECTIONS = 6
"""Dampings that are tried before a point counts as a minimum, or as a kink."""

Costs = Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, " models"]]
"""From a point to every model's cost."""
Linearised = Callable[
    [Float[np.ndarray, " n"], Int[np.ndarray, " tail"]],
    tuple[Float[np.ndarray, "tail residuals"], Float[np.ndarray, "tail residuals n"]],
]
"""From a point and some of the models to their residuals and Jacobians."""


@dataclasses.dataclass(frozen=True, eq=False)
class Tail(Merit):
    """The worst models at a point; their Jacobians are made when they are asked for."""

    cost: float
    """Mean cost of the tail [1]."""
    rows: Int[np.ndarray, " tail"]
    """The models in it."""
    linearised: Callable[
        [Int[np.ndarray, " tail"]],
        tuple[Float[np.ndarray, "tail residuals"], Float[np.ndarray, "tail residuals n"]],
    ]
    """Residuals and Jacobians of some models at the point."""

    @functools.cached_property
    def _model(self) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n n"]]:
        residuals, jacobian = self.linearised(self.rows)
        gradient = np.einsum("ija,ij->a", jacobian, residuals) / len(residuals)
        return gradient, np.einsum("ija,ijb->ab", jacobian, jacobian) / len(residuals)

    @property
    def gradient(self) -> Float[np.ndarray, " n"]:
        """Mean of the tail's $J^T r$."""
        return self._model[0]

    @property
    def matrix(self) -> Float[np.ndarray, "n n"]:
        """Mean of the tail's $J^T J$."""
        return self._model[1]


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
    progress: Progress = SILENT,
) -> Minimum[Tail]:
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

    def tail(at: Float[np.ndarray, " n"]) -> Tail:
        each = costs(at)
        return Tail(
            value_at_risk(each, share),
            tail_of(each, share),
            functools.partial(linearised, at),
        )

    stopping = Stopping(steps=iterations, rejections=_REJECTIONS, saving=tolerance, share=0.0)
    return minimise(tail, point, stopping=stopping, damping=_DAMPING, progress=progress)
