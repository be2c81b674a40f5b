"""Quantities as a fit's covariance leaves them possible."""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.robot.quantities import quantity


@dataclasses.dataclass(frozen=True, eq=False)
class NormalErrors:
    r"""Values of some quantities with normal errors.

    The error of a positive quantity is normal in its logarithm: $p\,e^{\sigma z / p}$.
    """

    names: tuple[str, ...]
    """Names of the quantities; one may come several times, at several settings."""
    values: Float[np.ndarray, " names"]
    """Their values [SI]."""
    sigma: Float[np.ndarray, " names"]
    """Their standard errors [SI]; 0 for what keeps its value."""
    correlation: Float[np.ndarray, "names names"]
    """Correlation of the errors [1]."""

    def draw(self, count: int, *, seed: int) -> Float[np.ndarray, "count names"]:
        """Draws of the values.

        Args:
            count: How many.
            seed: Of the random numbers.

        Returns:
            A row for each draw [SI].
        """
        normal = np.random.default_rng(seed).standard_normal((count, len(self.names)))
        errors = self.sigma * (normal @ root_of(self.correlation).T)
        columns = [
            _moved(name, float(value), error)
            for name, value, error in zip(self.names, self.values, errors.T, strict=True)
        ]
        return np.stack(columns, axis=1)


def root_of(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """Root of a covariance: itself times its transpose gives that.

    Args:
        covariance: The covariance; one that a file rounds may miss being positive by as much.

    Returns:
        The root.
    """
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def _moved(
    name: str, value: float, error: Float[np.ndarray, " count"]
) -> Float[np.ndarray, " count"]:
    if quantity(name).signed:
        return value + error
    return value * np.exp(error / value) if value > 0 else np.maximum(value + error, 0.0)
