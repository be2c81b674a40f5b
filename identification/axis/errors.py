r"""Standard errors of an axis's parameters, with what the horizons and the halves disagree by.

Within a law the long-run variance says how far noise and errors that come and go move a value.
A law that lacks something errs otherwise over a few samples than over the whole record, and
otherwise in the first half than in the second. By how much more these estimates scatter than
their own errors allow is DerSimonian and Laird's $\tau^2$. It is added, as wide as Student's
distribution makes what is known from so few: one estimate's error tells nothing of what its law
lacks.

References: R. DerSimonian, N. Laird, "Meta-analysis in clinical trials", Controlled Clinical
Trials 7(3), 1986, doi:10.1016/0197-2456(86)90046-2; J. Hartung, G. Knapp, "A refined method for
the meta-analysis of controlled clinical trials", Statistics in Medicine 20, 2001: Student's.
"""

import dataclasses

import numpy as np
from jaxtyping import Float
from scipy import special

from scdpr_jax.numerics.long_run_variance import Sandwich, sandwich

DISAGREEING = 4.0
"""Standard errors of their difference from which two halves don't agree."""


TELLING = 10.0
"""Standard error over that of all together up to which a part is evidence against it [1]: what
a part hardly tells hangs on a few of its samples, and on their rounding."""


@dataclasses.dataclass(frozen=True, eq=False)
class Alone:
    """What a part of the record, or one horizon, says by itself."""

    values: Float[np.ndarray, " n"]
    """Values [SI]."""
    sigma: Float[np.ndarray, " n"]
    """Standard errors [SI]; infinite for what it doesn't say."""


@dataclasses.dataclass(frozen=True, eq=False)
class Errors:
    """How exact an axis's parameters are."""

    covariance: Float[np.ndarray, "n n"]
    """Covariance, so large that 1.96 of its standard errors make a 95 % interval."""
    bandwidth: int
    """Samples over which residuals were taken to hang together."""
    halves: tuple[Alone, Alone]
    """What each half of the record says."""

    def changes(self, index: int) -> float:
        """By how much a parameter differs between the halves.

        Args:
            index: Its number.

        Returns:
            Their difference over its standard error [1]; 0 where a half doesn't say.
        """
        first, second = self.halves
        variance = first.sigma[index] ** 2 + second.sigma[index] ** 2
        if not 0 < variance < np.inf:
            return 0.0
        return abs(float(second.values[index] - first.values[index])) / float(np.sqrt(variance))


def errors(
    values: Float[np.ndarray, " n"],
    residuals: Float[np.ndarray, "horizons samples"],
    jacobian: Float[np.ndarray, "horizons samples n"],
) -> Errors:
    """Standard errors of a minimum.

    Args:
        values: Values there [SI].
        residuals: Residuals of each horizon, over its root mean square.
        jacobian: Their derivatives with respect to the values.

    Returns:
        The errors.
    """
    together = sandwich(jacobian, residuals)
    within = _variance(jacobian, residuals, together)
    most = TELLING * np.sqrt(within)
    by_horizon = [_alone(values, r, j, most) for r, j in zip(residuals, jacobian, strict=True)]
    middle = residuals.shape[1] // 2
    first, second = (
        _alone(values, residuals[:, part], jacobian[:, part], most)
        for part in (slice(0, middle), slice(middle, None))
    )
    between = np.maximum(_between(by_horizon), _between([first, second]))
    # Horizons and halves are that many estimates, less one for their mean.
    between *= (special.stdtrit(len(by_horizon) + 1, 0.975) / 1.96) ** 2
    total = within + between
    variance = np.diag(together.covariance)
    share = np.divide(total, variance, out=np.ones(len(values)), where=variance > 0)
    growth = np.sqrt(share)
    covariance = together.covariance * np.outer(growth, growth)
    return Errors(covariance, together.bandwidth, (first, second))


def _alone(
    values: Float[np.ndarray, " n"],
    residuals: Float[np.ndarray, "*kinds samples"],
    jacobian: Float[np.ndarray, "*kinds samples n"],
    most: Float[np.ndarray, " n"],
) -> Alone:
    """What some of the residuals say, by a step of Gauss and Newton to their own minimum."""
    flat = jacobian.reshape(-1, len(values))
    scale = np.linalg.norm(flat, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    step, _, rank, _ = np.linalg.lstsq(flat / scale, -residuals.reshape(-1), rcond=1e-9)
    left = residuals + jacobian @ (step / scale)
    sigma = np.sqrt(_variance(jacobian, left, sandwich(jacobian, left)))
    if rank < len(values):
        sigma = np.full(len(values), np.inf)
    return Alone(values + step / scale, np.where((sigma > 0) & (sigma <= most), sigma, np.inf))


def _variance(
    jacobian: Float[np.ndarray, "*kinds samples n"],
    residuals: Float[np.ndarray, "*kinds samples"],
    robust: Sandwich,
) -> Float[np.ndarray, " n"]:
    """Variances that are robust, and no less than white noise of the residuals' size leaves.

    A value that hangs on a few samples is fitted to them, and their scores vanish with them.
    """
    flat = jacobian.reshape(-1, jacobian.shape[-1])
    scale = np.linalg.norm(flat, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv((flat / scale).T @ (flat / scale), hermitian=True)
    white = np.mean(residuals**2) * np.diag(inverse) / scale**2
    return np.maximum(np.diag(robust.covariance), white)


def _between(parts: list[Alone]) -> Float[np.ndarray, " n"]:
    r"""Variance $\tau^2$ by which estimates scatter beyond their own errors."""
    weight = np.stack([1 / np.square(part.sigma) for part in parts])
    estimate = np.stack([part.values for part in parts])
    total = weight.sum(axis=0)
    total = np.where(total > 0, total, 1.0)
    mean = (weight * estimate).sum(axis=0) / total
    scatter = (weight * np.square(estimate - mean)).sum(axis=0)
    spared = total - np.square(weight).sum(axis=0) / total
    excess = np.maximum(scatter - (np.count_nonzero(weight, axis=0) - 1), 0.0)
    return np.divide(excess, spared, out=np.zeros_like(excess), where=spared > 1e-9 * total)
