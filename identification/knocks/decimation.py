r"""A long fast record with as many samples as its vibrations need.

Means of k samples one after the other carry the same modes: a filter multiplies a decaying
sine by a number and leaves its frequency and its decay, and white noise stays white,
$\sqrt k$ times smaller. So nothing is lost as long as a period of the fastest mode keeps
several samples; what is faster and doesn't stand out of the noise is averaged away instead of
being folded down.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

FEWEST = 600
"""Samples below which a record stays as it is: a fit of them takes a tenth of a second."""
A_PERIOD = 10.0
"""Samples that a period of the fastest vibration keeps [1]: means of that many make it 1.6 %
smaller, which is put right, and its standard errors larger by as much."""
STANDS_OUT = 10.0
"""Power over the noise's, beyond the logarithm of their number, at which a frequency counts
[1]: by chance in one record of 20,000."""
PARTS = (1, 4, 16)
"""Into how many parts the record is divided to look for what stands out of its noise; parts of
a record of 5 s then show a vibration that lasts for a tenth of a second."""
_GAP = 1.5
"""Length of k samples over what it should be, beyond which there is a gap among them [1]."""


class Thinned(NamedTuple):
    """A record of means."""

    time: Float[np.ndarray, " samples"]
    """Mean time of each [s]."""
    signal: Float[np.ndarray, " samples"]
    """Means, in units of their own noise."""
    together: int
    """How many samples are one."""
    interval: float
    """Time between two of the samples that it was made of [s]."""

    def amplitude(self, frequency: float) -> float:
        """The record's amplitude over that of the means, in one unit of noise.

        Args:
            frequency: Frequency of a vibration [Hz].

        Returns:
            The ratio [1].
        """
        half = np.pi * frequency * self.interval
        shrunk = np.sin(self.together * half) / (self.together * np.sin(half))
        return float(1 / (shrunk * np.sqrt(self.together)))


def thinned(
    time: Float[np.ndarray, " samples"], signal: Float[np.ndarray, " samples"]
) -> Thinned:
    """A record with as few samples as its vibrations need.

    Args:
        time: Time of each sample [s], strictly increasing.
        signal: The signal in units of its noise.

    Returns:
        Means of samples, `FEWEST` of them at the least; the record itself where it is short or
        where something fast stands out of its noise.
    """
    interval = float(np.median(np.diff(time)))
    together = min(
        len(time) // FEWEST, int(1 / (A_PERIOD * interval * _fastest(signal, interval)))
    )
    if together < 2:
        return Thinned(time, signal, 1, interval)
    count = len(time) // together
    times, signals = (
        own[: count * together].reshape(count, together) for own in (time, signal)
    )
    whole = times[:, -1] - times[:, 0] <= _GAP * (together - 1) * interval
    means = times[whole].mean(axis=1), np.sqrt(together) * signals[whole].mean(axis=1)
    return Thinned(*means, together, interval)


def _fastest(signal: Float[np.ndarray, " samples"], interval: float) -> float:
    """The highest frequency that stands out of the noise, or that of one period [Hz].

    What dies out soon stands out of a part of the record only.
    """
    highest = 1 / (len(signal) * interval)
    for parts in PARTS:
        length = len(signal) // parts
        begins = range(0, len(signal) - length + 1, max(length // 2, 1))
        rows = np.stack([signal[begin : begin + length] for begin in begins])
        line = np.vander(np.arange(length) / length, 2)
        rest = rows.T - line @ np.linalg.lstsq(line, rows.T, rcond=None)[0]
        window = np.hanning(length)[:, None]
        power = np.abs(np.fft.rfft(window * rest, axis=0)) ** 2 / np.sum(window**2)
        standing = np.flatnonzero(np.max(power, axis=1) > np.log(rows.size) + STANDS_OUT)
        if standing.size:
            highest = max(highest, standing[-1] / (length * interval))
    return highest
