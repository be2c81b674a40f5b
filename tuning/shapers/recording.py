r"""A spectrum of a raw recording of accelerations, by Welch's method.

The recording is cut into stretches that overlap by half, each is weighed by a Hann window and
transformed, and the powers are averaged. One transform of all of it would show finer lines, and
each of them with an error as large as itself.
"""

import pathlib
from collections.abc import Mapping

import numpy as np
import scipy.signal
from jaxtyping import Float

from tuning.shapers.spectrum import Spectrum
from tuning.shapers.spectrum_file import SpectrumFile

_STRETCHES = 8
"""Stretches that overlap by half in a short recording: powers are then known to a third."""
_LONGEST = 8.0
"""Longest stretch [s]: an eighth of a hertz tells apart what a shaper can."""
_FEWEST = 64
"""Samples of a stretch at least."""
_HIGHEST = 200.0
"""Highest frequency that is kept [Hz]: what is faster, no shaper of a motion is for."""
_EVEN = 0.01
"""Scatter of the steps over their middle up to which samples are evenly spaced [1]."""


def spectrum_of_recording(
    path: pathlib.Path,
    time: Float[np.ndarray, " samples"],
    axes: Mapping[str, Float[np.ndarray, " samples"]],
    *,
    told: tuple[str, ...] = (),
    normalised: bool = False,
    lowest: float = 0.0,
) -> SpectrumFile:
    """The spectrum of a recording, as if it had been measured as one.

    Args:
        path: The recording's file.
        time: Time of each sample [s], increasing.
        axes: Accelerations by axis, in one unit; their powers are summed.
        told: How it was read, for the notes.
        normalised: Whether it was shaken alike at every frequency; else the force grew with the
            frequency, and the density is divided by it.
        lowest: Frequencies up to here are left out [Hz]; 0 is, always.

    Returns:
        The spectrum, with what was done and what it can't know among its notes.

    Raises:
        ValueError: If the recording is too short, or nothing shakes in it.
    """
    step = float(np.median(np.diff(time)))
    rate = 1 / step
    length = int(min(2 * len(time) / (_STRETCHES + 1), _LONGEST * rate))
    if length < _FEWEST:
        raise ValueError(
            f"{path}: a recording of {len(time)} samples, {len(time) * step:.3g} s, expected "
            f"{_FEWEST * (_STRETCHES + 1) // 2} samples at least. Shake it for longer."
        )
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step) + 1)
    scatter = float(np.std(np.diff(time))) / step
    density = np.zeros(length // 2 + 1)
    for values in axes.values():
        even = values if scatter < _EVEN else np.interp(grid, time, values)
        frequency, power = scipy.signal.welch(even, rate, nperseg=length)
        density = density + power
    kept = (frequency > 0) & (frequency >= lowest) & (frequency <= _HIGHEST)
    frequency, density = frequency[kept], density[kept]
    if frequency.size < 8 or not density.max() > 0:
        raise ValueError(
            f"{path}: {np.count_nonzero(density)} bins of {frequency.size} with vibration, "
            f"expected 8 at least. Record the shaking again, and keep more than {lowest:g} Hz."
        )
    power = density if normalised else density / frequency
    notes = (
        *told,
        *_done(length, rate, len(time), scatter, normalised),
        _unknown(rate, normalised),
    )
    name = " + ".join(axes)
    return SpectrumFile(
        path, Spectrum(frequency, power / power.max()), (name,), normalised, notes
    )


def _done(
    length: int, rate: float, samples: int, scatter: float, normalised: bool
) -> list[str]:
    """What was done, in words."""
    stretches = (samples - length // 2) // (length - length // 2)
    made = [
        f"The spectrum is Welch's: {stretches} stretches of {length / rate:.3g} s that overlap "
        f"by half, Hann's window, bins of {rate / length:.3g} Hz, axes summed, up to "
        f"{min(rate / 2, _HIGHEST):.4g} Hz."
    ]
    if scatter >= _EVEN:
        made.append(
            f"The samples aren't evenly spaced, steps scatter by {100 * scatter:.2g} %: they "
            "are interpolated, which weakens what is near half the rate."
        )
    how = "as they are" if normalised else "over the frequency"
    why = "as was asked for" if normalised else "as for shaking whose force grows with it"
    made.append(f"Densities are taken {how}, {why}.")
    return made


def _unknown(rate: float, normalised: bool) -> str:
    """What a recording can't know, in words."""
    shaken = "alike at every frequency" if normalised else "with a force that grows with it"
    return (
        "What a recording can't know: what shook the machine, for the spectrum is the "
        f"machine's only if it was shaken {shaken}; in which direction the chip sat; and what "
        f"vibrates faster than {rate / 2:.4g} Hz, which shows as something slower."
    )
