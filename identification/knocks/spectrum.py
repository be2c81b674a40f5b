"""Amplitude spectrum of a camera record, and the paper's natural frequency, section 5.2."""

import dataclasses

import numpy as np
import scipy.interpolate
from jaxtyping import Float

_PADDING = 16  # times the record: bins so fine that a parabola through three fits the peak
_FEWEST = 8  # samples
_CYCLES = 1.5  # periods in the record: fewer can't be told from a drift


@dataclasses.dataclass(frozen=True)
class SpectralPeak:
    """The highest peak of an amplitude spectrum."""

    frequency: float
    """Frequency of the peak [Hz]."""
    amplitude: float
    """Amplitude of the sine that would stand so high [in the signal's unit]."""
    resolution: float
    """Reciprocal of the record's length [Hz]: modes closer than it appear as one peak, and
    a decay or drift in the record can shift the peak by a good part of it."""


def amplitude_spectrum(
    time: Float[np.ndarray, " samples"], signal: Float[np.ndarray, " samples"]
) -> tuple[Float[np.ndarray, " bins"], Float[np.ndarray, " bins"]]:
    """One-sided amplitude spectrum of an unevenly sampled signal, its mean removed.

    Lost samples (NaN) are left out, the rest is interpolated onto an even grid of the
    median sample distance, and zeros are appended to make the bins narrow, which shows the
    peaks' shape but adds no resolution. A sine of amplitude A shows as a peak of height A,
    less what interpolation takes from it near the Nyquist frequency.

    Args:
        time: Time of each sample [s], increasing.
        signal: The signal, NaN where it was lost.

    Returns:
        Frequencies [Hz] from 0 to half the median sampling rate, and amplitudes [in the
        signal's unit].

    Raises:
        ValueError: If fewer than 8 samples are left.
    """
    grid, values = _even(time, signal)
    length = _PADDING * len(grid)
    frequency = np.fft.rfftfreq(length, grid[1] - grid[0])
    return frequency, 2 / len(grid) * np.abs(np.fft.rfft(values - values.mean(), length))


def natural_frequency(
    time: Float[np.ndarray, " samples"], displacement: Float[np.ndarray, " samples"]
) -> SpectralPeak:
    """Natural frequency by peak picking, section 5.2.

    The displacement's mean is removed, it is Fourier transformed, and the highest peak is
    taken; a parabola through it and its neighbours gives the place between the bins. Peaks
    of fewer than one and a half periods in the record are passed over.

    Args:
        time: Time of each sample [s], increasing.
        displacement: Displacement of the end-effector [m], NaN where it was lost.

    Returns:
        The peak, with the resolution that the record allows.

    Raises:
        ValueError: If fewer than 8 samples are left, or the spectrum has no peak.
    """
    frequency, amplitude = amplitude_spectrum(time, displacement)
    seen = time[np.isfinite(displacement)]
    duration = float(seen[-1] - seen[0])
    inner = amplitude[1:-1]
    peaks = (inner > amplitude[:-2]) & (inner >= amplitude[2:])
    places = 1 + np.flatnonzero(peaks & (frequency[1:-1] * duration >= _CYCLES))
    if len(places) == 0:
        raise ValueError(
            f"the spectrum of {duration:.3g} s has no peak above {_CYCLES / duration:.3g} Hz, "
            "expected one at the natural frequency. Record the ring-down for longer."
        )
    top = places[np.argmax(amplitude[places])]
    left, middle, right = amplitude[top - 1 : top + 2]
    bend = left - 2 * middle + right
    shift = 0.5 * (left - right) / bend
    return SpectralPeak(
        frequency=float(frequency[top] + shift * frequency[1]),
        amplitude=float(middle - 0.25 * (left - right) * shift),
        resolution=1 / duration,
    )


def _even(
    time: Float[np.ndarray, " samples"], signal: Float[np.ndarray, " samples"]
) -> tuple[Float[np.ndarray, " grid"], Float[np.ndarray, " grid"]]:
    """The signal on an even grid [s] of the median sample distance."""
    seen = np.isfinite(signal)
    if np.sum(seen) < _FEWEST:
        raise ValueError(
            f"{np.sum(seen)} samples with a position, expected at least {_FEWEST} for a "
            "spectrum. Check the camera's view of the marker."
        )
    time, signal = time[seen], signal[seen]
    step = float(np.median(np.diff(time)))
    # Akima's cubic neither overshoots in a gap as a spline does nor blunts as lines do.
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step) + 1)
    return grid, scipy.interpolate.Akima1DInterpolator(time, signal)(grid)
