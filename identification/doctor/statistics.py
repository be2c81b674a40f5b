"""Robust figures of signals: spread, travel, slopes with their error, non-negative fits."""

import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64, Shaped

NORMAL = 1.4826
"""Standard deviation over the median absolute deviation, of normal noise."""


def middle(values: Float[np.ndarray, " _"]) -> float:
    """Median of finite values: `numpy.median` spends most of its time on what these aren't.

    Args:
        values: Values, at least one.

    Returns:
        The median.
    """
    half = len(values) // 2
    if len(values) % 2:
        return float(np.partition(values, half)[half])
    pair = np.partition(values, (half - 1, half))
    return float(pair[half - 1] + pair[half]) / 2


def spread(values: Float[np.ndarray, " _"]) -> float:
    """Standard deviation of most of the values, from the median absolute deviation.

    Args:
        values: Values; NaN doesn't count.

    Returns:
        The spread, 0 for none.
    """
    seen = values[np.isfinite(values)]
    if not seen.size:
        return 0.0
    return NORMAL * middle(np.abs(seen - middle(seen)))


def travel(values: Float[np.ndarray, " _"]) -> float:
    """Largest minus smallest value.

    Args:
        values: Values; NaN doesn't count.

    Returns:
        The travel, 0 for none.
    """
    seen = values[np.isfinite(values)]
    return float(np.ptp(seen)) if seen.size else 0.0


class Slope(NamedTuple):
    """A slope through several runs."""

    value: float
    """The slope."""
    sigma: float
    """Its standard error."""
    correlation: float
    """Correlation of the weighted samples."""


def slope(runs: Iterable[tuple[Float64[np.ndarray, " _"], ...]]) -> Slope | None:
    """Slope of one signal on another, with an intercept for each run.

    The weights are Huber's, so that a few bad frames, or a stretch in which an elastic
    cable gives way, move it by their number and not by their size.

    Args:
        runs: Pairs of signals (on what, which); NaN doesn't count.

    Returns:
        The slope, None if nothing moves.
    """
    bases, signals = [], []
    for base, signal in runs:
        seen = np.isfinite(base + signal)
        if seen.sum() > 5:
            bases.append(base[seen] - middle(base[seen]))
            signals.append(signal[seen] - middle(signal[seen]))
    if not bases:
        return None
    group = np.repeat(np.arange(len(bases)), [len(base) for base in bases])
    base, signal = np.concatenate(bases), np.concatenate(signals)
    weight = np.ones(len(base))
    for _ in range(8):
        total = np.bincount(group, weight)
        u = base - (np.bincount(group, weight * base) / total)[group]
        v = signal - (np.bincount(group, weight * signal) / total)[group]
        power = float(np.sum(weight * u * u))
        if power == 0:
            return None
        value = float(np.sum(weight * u * v)) / power
        error = v - value * u
        noise = max(spread(error), 1e-12)
        weight = huber(error, 2 * noise)
    size = math.sqrt(max(power * float(np.sum(weight * v * v)), 1e-300))
    return Slope(value, noise / math.sqrt(power), float(np.sum(weight * u * v)) / size)


def huber(error: Float64[np.ndarray, " _"], width: float) -> Float64[np.ndarray, " _"]:
    """Weights of a least-squares fit that make it Huber's.

    Args:
        error: Residuals.
        width: Residual from which on the weight falls.

    Returns:
        The weights.
    """
    return 1 / np.maximum(1, np.abs(error) / width)


def non_negative(
    matrix: Float64[np.ndarray, "rows columns"], right: Float64[np.ndarray, " rows"]
) -> Float64[np.ndarray, " columns"]:
    """Least squares whose unknowns can't be negative, for a handful of them.

    The problem is convex: if the free minimum has no negative, it is the one. Else every set
    of unknowns that are free is tried; three unknowns have six smaller ones.

    Args:
        matrix: The regressors.
        right: What they are to explain.

    Returns:
        The unknowns.
    """
    columns = matrix.shape[1]
    # A column of zeros makes the powers singular: next to nothing on the diagonal holds it.
    power = matrix.T @ matrix
    power = power + np.eye(columns) * (1e-12 * np.trace(power) + 1e-300)
    product = matrix.T @ right
    best, least = np.zeros(columns), 0.0
    for size in range(columns, 0, -1):
        for free in itertools.combinations(range(columns), size):
            part = list(free)
            inner = np.linalg.solve(power[part][:, part], product[part])
            cost = -float(inner @ product[part])
            if cost < least and np.all(inner >= 0):
                best, least = np.zeros(columns), cost
                best[part] = inner
                if size == columns:
                    return best
    return best


def longest_still(values: Shaped[np.ndarray, " _"]) -> tuple[int, int]:
    """The longest stretch of exactly equal values.

    Args:
        values: Values.

    Returns:
        Its first index, and the one behind its last.
    """
    edges = np.r_[-1, np.flatnonzero(np.diff(values) != 0), len(values) - 1]
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]) + 1, int(edges[longest + 1]) + 1
