"""The long-run variance: covariance of a least-squares fit whose residuals are correlated.

What a few parameters leave over is mostly the rig's departure from the model, and it keeps its
sign for many samples. The variance of a sum of such scores is the long-run variance: the sum
of their autocovariances over all lags, here with weights that fall to zero at a bandwidth that
the scores themselves suggest. Taking the residuals for white noise would be simpler and makes
intervals several times too narrow; a model of the noise (an autoregression) is one more thing
to be wrong about.
"""

import dataclasses

import numpy as np
from jaxtyping import Float


@dataclasses.dataclass(frozen=True, eq=False)
class Sandwich:
    """Covariance of fitted parameters, robust to correlated and unequal residuals."""

    covariance: Float[np.ndarray, "parameters parameters"]
    """Covariance of the parameters, so large that 1.96 of its standard errors make a 95 %
    interval."""
    bandwidth: int
    """Samples over which residuals were taken to hang together."""


def sandwich(
    jacobian: Float[np.ndarray, "*kinds samples parameters"],
    residuals: Float[np.ndarray, "*kinds samples"],
) -> Sandwich:
    r"""Newey–West covariance with Andrews' bandwidth and fixed-$b$ critical value.

    $$ C = \frac{n}{n - p} (J^T J)^{-1}
           \Big[\sum_{|k| < L} (1 - |k|/L)\, \Gamma_k\Big] (J^T J)^{-1}, \qquad
       \Gamma_k = \sum_t g_t g_{t+k}^T, \quad g_t = J_t r_t $$

    Residuals that are model error rather than noise stay of one sign for a long while:
    the usual $\sigma^2 (J^T J)^{-1}$ then promises far too much. The bracket is a sum over
    all windows of length $L$ of the squared sum of scores, so it is never negative. A
    bandwidth that is a fair share $b = L/n$ of the record makes the covariance itself
    uncertain, which the wider critical value allows for. Several kinds of residuals of the
    same samples, as of predictions over several horizons, hang together at each instant: their
    scores are added before anything is squared.

    Args:
        jacobian: Derivatives of the residuals.
        residuals: Residuals at the optimum; of several kinds where there are more axes.

    Returns:
        The covariance, with what it rests on.

    References:
        W. Newey, K. West, "A simple, positive semi-definite, heteroskedasticity and
        autocorrelation consistent covariance matrix", Econometrica 55(3), 1987.
        D. Andrews, "Heteroskedasticity and autocorrelation consistent covariance matrix
        estimation", Econometrica 59(3), 1991: the bandwidth.
        N. Kiefer, T. Vogelsang, "A new asymptotic theory for heteroskedasticity-
        autocorrelation robust tests", Econometric Theory 21(6), 2005: the critical value.
    """
    samples, parameters = jacobian.shape[-2:]
    stacked, flat = jacobian.reshape(-1, parameters), residuals.reshape(-1)
    scale = np.linalg.norm(stacked, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    scores = (stacked / scale * flat[:, None]).reshape(-1, samples, parameters).sum(axis=0)
    length = _bandwidth(scores)

    padded = np.pad(scores, ((length, length - 1), (0, 0)))
    sums = np.cumsum(padded, axis=0)
    windows = sums[length:] - sums[:-length]
    bread, undetermined = _inverse(stacked / scale)
    root = bread @ windows.T
    noise = float(flat @ flat) / samples
    middle = root @ root.T / length + noise * undetermined
    covariance = samples / (samples - parameters) * middle
    share = length / samples
    critical_value = 1.9600 + 2.9694 * share + 0.4160 * share**2 - 0.5324 * share**3
    growth = (critical_value / 1.96) ** 2
    return Sandwich(growth * covariance / np.outer(scale, scale), bandwidth=length)


def _bandwidth(scores: Float[np.ndarray, "samples parameters"]) -> int:
    """Andrews' bandwidth of Bartlett's kernel from a first-order autoregression a score."""
    samples = len(scores)
    power = np.sum(scores[:-1] ** 2, axis=0)
    power = np.where(power > 0, power, 1.0)
    memory = np.clip(np.sum(scores[1:] * scores[:-1], axis=0) / power, -0.99999, 0.99999)
    innovation = np.mean((scores[1:] - memory * scores[:-1]) ** 2, axis=0)
    total = np.sum(innovation**2 / (1 - memory) ** 4)
    curvature = np.sum(4 * memory**2 * innovation**2 / ((1 - memory) ** 6 * (1 + memory) ** 2))
    if not total > 0:
        return 1
    length = 1.1447 * (curvature / total * samples) ** (1 / 3)
    # Four windows at the least: with fewer there is nothing to judge their spread by.
    return int(np.clip(np.ceil(length), 1, samples // 4))


def _inverse(
    jacobian: Float[np.ndarray, "samples parameters"],
) -> tuple[
    Float[np.ndarray, "parameters parameters"], Float[np.ndarray, "parameters parameters"]
]:
    """Inverse of the normal matrix: its part that is determined, and the rest, huge.

    A direction that changes no residual has no scores either: left in the sandwich, it
    would seem to be known exactly.
    """
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    # Eigenvalues of unit columns are sums of `samples` products: rounding is below this.
    floor = np.finfo(float).eps * len(jacobian) * max(float(values[-1]), 1.0)
    inverse = np.where(values > floor, 1 / np.maximum(values, floor), 0.0)
    huge = np.where(values > floor, 0.0, 1 / floor)
    return vectors * inverse @ vectors.T, vectors * huge @ vectors.T
