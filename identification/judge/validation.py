"""Whether what a simulation leaves of a run is noise: fit, whiteness, independence."""

import dataclasses

import numpy as np
from jaxtyping import Float
from scipy import special

from identification.fit.comparison import CAMERA, ENCODERS, Comparison

LAGS = 12
"""Lags of the whiteness test: 0.4 s of a camera's frames, a period of the slowest mode."""

LEVEL = 1e-3
"""Level of both tests [1]: a campaign has a hundred channels, and noise should pass them."""

FEWEST = 4 * LAGS
"""Samples below which nothing is tested."""


@dataclasses.dataclass(frozen=True)
class ChannelValidation:
    """What is left of one channel of a run."""

    run: str
    """Name of the run."""
    channel: str
    """Name of the column."""
    held_out: bool
    """Whether the run said nothing about the shared quantities."""
    fit: float
    """Share of the channel's own spread that is explained, 1 for all of it [1]."""
    whiteness: float
    """Probability of such residuals if they were white; NaN where there are too few [1]."""
    independence: float
    """The same for residuals that know nothing of the voltages [1]."""
    is_rounding: bool
    """Whether an encoder's residuals stay within a count: rounding isn't white, but noise."""

    @property
    def verdict(self) -> str:
        """In words what the residuals look like."""
        if self.is_rounding:
            return "noise"
        if np.isnan(self.whiteness):
            return "too few samples to tell"
        if self.whiteness >= LEVEL and self.independence >= LEVEL:
            return "noise"
        if self.independence < LEVEL:
            return "follows the voltages: the dynamics miss something"
        return "hangs together in time, not with the voltages: a disturbance, or a sensor's"


def validate(comparison: Comparison) -> tuple[ChannelValidation, ...]:
    r"""How white what is left of a run's channels is, and how independent of its voltages.

    Whiteness is Ljung and Box's test over `LAGS` lags. Independence is the largest
    correlation with the voltages' sum or difference over as many lags, by Fisher's
    transformation and Bonferroni's bound. Of an encoder every reading counts once, however
    long it stands.

    Reference: G. M. Ljung, G. E. P. Box, "On a measure of lack of fit in time series
    models", Biometrika 65(2), 1978, doi:10.1093/biomet/65.2.297.

    Args:
        comparison: The run beside its simulation.

    Returns:
        One for each channel that was measured.
    """
    channels = []
    for number, name in enumerate(ENCODERS):
        measured = comparison.measured_angle[:, number]
        counts = np.diff(np.unique(measured))
        changes = np.flatnonzero(np.append(True, np.diff(measured) != 0))
        middle = (changes + np.append(changes[1:], measured.size) - 1) // 2
        pair = measured[middle], comparison.simulated_angle[middle, number]
        count = float(counts.min()) if counts.size else 0.0
        channels.append((name, comparison.time[middle], *pair, count))
    for number, name in enumerate(CAMERA):
        seen = np.isfinite(comparison.measured[:, number])
        if np.any(seen):
            pair = comparison.measured[seen, number], comparison.simulated[seen, number]
            channels.append((name, comparison.frame_time[seen], *pair, 0.0))
    return tuple(_channel(comparison, *channel) for channel in channels)


def _channel(
    comparison: Comparison,
    name: str,
    time: Float[np.ndarray, " n"],
    measured: Float[np.ndarray, " n"],
    simulated: Float[np.ndarray, " n"],
    count: float,
) -> ChannelValidation:
    """What is left of a channel; of an encoder with the size of its count."""
    residual = measured - simulated
    spread = float(np.linalg.norm(measured - np.mean(measured)))
    fit = 1 - float(np.linalg.norm(residual)) / spread if spread > 0 else np.nan
    white, independent = np.nan, np.nan
    if residual.size >= FEWEST and np.ptp(residual) > 0:
        rows = np.clip(np.searchsorted(comparison.time, time) - 1, 0, None)
        voltage = comparison.voltage[rows]
        inputs = [voltage.sum(axis=1), voltage[:, 0] - voltage[:, 1]]
        white = ljung_box(residual)
        independent = min(independence(residual, moved) for moved in inputs)
    return ChannelValidation(
        comparison.name,
        name,
        comparison.held_out,
        fit,
        white,
        independent,
        bool(np.max(np.abs(residual)) <= count),
    )


def ljung_box(residual: Float[np.ndarray, " n"]) -> float:
    """Probability of such correlations over `LAGS` lags if the residuals were white.

    Args:
        residual: The residuals, more than `LAGS` of them.

    Returns:
        The probability [1].
    """
    centred = residual - np.mean(residual)
    count, power = centred.size, float(centred @ centred)
    lags = np.arange(1, LAGS + 1)
    correlation = np.array([centred[k:] @ centred[:-k] for k in lags]) / power
    statistic = count * (count + 2) * np.sum(np.square(correlation) / (count - lags))
    return float(special.chdtrc(LAGS, statistic))


def _correlation(first: Float[np.ndarray, " n"], second: Float[np.ndarray, " n"]) -> float:
    """Correlation of two series, `numpy.corrcoef` without the matrix that it is taken from."""
    first, second = first - np.mean(first), second - np.mean(second)
    return float(first @ second / np.sqrt((first @ first) * (second @ second)))


def independence(residual: Float[np.ndarray, " n"], moved: Float[np.ndarray, " n"]) -> float:
    """Probability of such a correlation with an input if the residuals knew nothing of it.

    Args:
        residual: The residuals.
        moved: The input at the same instants.

    Returns:
        The probability, 1 for an input that stands still [1].
    """
    if not np.ptp(moved) > 0:
        return 1.0
    largest = 0.0
    for lag in range(LAGS + 1):
        late, early = residual[lag:], moved[: moved.size - lag]
        if np.ptp(early) > 0 and np.ptp(late) > 0:
            largest = max(largest, abs(_correlation(late, early)))
    # An input that is held is no more samples than it has steps, if these are fewer.
    count = residual.size - LAGS
    statistic = np.arctanh(min(largest, 1 - 1e-12)) * np.sqrt(max(count - 3, 1))
    return float(min(2 * special.ndtr(-statistic) * (LAGS + 1), 1.0))
