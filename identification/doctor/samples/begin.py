"""A channel at a run's first row, by the samples that come first.

Polynomials through them are followed back. Of two degrees the difference tells what the
polynomial misses, the residuals tell the noise, and both together how well value and slope are
known there. A difference of the first two samples is simpler, and is all noise.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

FEWEST = 6
"""Samples that it takes: two more than a cubic has numbers."""


@dataclasses.dataclass(frozen=True)
class Begin:
    """A channel at the run's first row."""

    value: float
    """What it is [the channel's unit]."""
    error: float
    """Standard error of that."""
    slope: float
    """How fast it moves [the channel's unit a second]."""
    slope_error: float
    """Standard error of that."""


def at_begin(
    time: Float[np.ndarray, " samples"],
    values: Float[np.ndarray, " samples"],
    span: float,
    sigma: float,
) -> Begin:
    """Value and slope at time 0, and how well they are known.

    Args:
        time: Time since the run's first row [s].
        values: The channel, NaN where it was lost.
        span: Time over which samples count [s]; more where there are too few in it.
        sigma: Standard deviation of the noise.

    Returns:
        Both; without enough samples the first one, which may move at any speed.
    """
    seen = np.flatnonzero(np.isfinite(values))
    rows = seen[: max(FEWEST, int(np.count_nonzero(time[seen] <= span)))]
    if len(rows) < FEWEST:
        first = float(values[rows[0]]) if len(rows) else 0.0
        return Begin(first, np.inf, 0.0, np.inf)
    reach = float(time[rows[-1]])
    basis = np.vander(time[rows] / reach, 4, increasing=True)
    cubic, *_ = np.linalg.lstsq(basis, values[rows], rcond=None)
    square, *_ = np.linalg.lstsq(basis[:, :3], values[rows], rcond=None)
    left = values[rows] - basis @ cubic
    noise = max(sigma, float(np.sqrt(left @ left / (len(rows) - 4 or 1))))
    by_noise = noise * np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)))[:2]
    value, slope = np.hypot(by_noise, np.abs(cubic[:2] - square[:2]))
    return Begin(float(cubic[0]), float(value), float(cubic[1]) / reach, float(slope) / reach)
