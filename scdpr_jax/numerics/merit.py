"""What a search lowers, at a point: the merit and its Gauss–Newton model.

A sum of squares knows its second derivative without anybody deriving twice: $J^T J$ misses only
what the residuals' curvature adds, which is small where the residuals are. So a merit is a
number, a gradient and that matrix. A search looks at the number alone until a point is the best
so far, so derivatives that cost something are made when they are first asked for.
"""

import dataclasses
import functools
import math

import numpy as np
from jaxtyping import Float


class Merit:
    """What is minimised, at a point, with its Gauss–Newton model."""

    cost: float
    """The merit, not finite where there is none."""
    gradient: Float[np.ndarray, " n"]
    r"""Weighted $J^T r$, half the gradient of the merit."""
    matrix: Float[np.ndarray, "n n"]
    r"""Weighted $J^T J$, half the Gauss–Newton model's second derivative."""


@dataclasses.dataclass(frozen=True, eq=False)
class Normal(Merit):
    """A misfit at a point as its normal equations."""

    cost: float
    gradient: Float[np.ndarray, " n"]
    matrix: Float[np.ndarray, "n n"]

    def plus(self, other: "Normal") -> "Normal":
        """The normal equations of both misfits together.

        Args:
            other: Those of another misfit of the same unknowns.

        Returns:
            Their sums.
        """
        return Normal(
            self.cost + other.cost,
            self.gradient + other.gradient,
            self.matrix + other.matrix,
        )


@dataclasses.dataclass(frozen=True, eq=False)
class SumOfSquares(Merit):
    """The sum of squared residuals; its normal equations are made when they are asked for."""

    residuals: Float[np.ndarray, " m"]
    """Residuals at the point."""
    jacobian: Float[np.ndarray, "m n"]
    """Their derivatives there."""

    @functools.cached_property
    def cost(self) -> float:
        """The sum, infinite where a residual or a derivative isn't finite."""
        if not (np.all(np.isfinite(self.residuals)) and np.all(np.isfinite(self.jacobian))):
            return math.inf
        return float(self.residuals @ self.residuals)

    @functools.cached_property
    def gradient(self) -> Float[np.ndarray, " n"]:
        """$J^T r$."""
        return self.jacobian.T @ self.residuals

    @functools.cached_property
    def matrix(self) -> Float[np.ndarray, "n n"]:
        """$J^T J$."""
        return self.jacobian.T @ self.jacobian
