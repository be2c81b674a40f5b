"""The free vibration after a knock: measured, fitted, and its spectrum."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from experiments.page.number_text import rounded
from experiments.page.style import (
    BLUE,
    GREY,
    VERMILION,
    label,
    legend_above,
    new_figure,
    styled,
)
from identification.campaign.types import Run
from identification.knocks.ring_down import RingDown, ring_down
from identification.knocks.spectrum import amplitude_spectrum

_MARGIN = 0.05  # s: a frame and a half between the knock and the first sample in use
_CLOCK = 0.1  # s: the same where the camera's clock is unknown by some tens of ms


class FittedDecay(NamedTuple):
    """A ring-down's curve, and the spectrum of what was measured."""

    time: Float[np.ndarray, " points"]
    """Time on the camera's clock [s], within the fitted window."""
    displacement: Float[np.ndarray, " points"]
    """The fitted displacement [m]."""
    frequency: Float[np.ndarray, " bins"]
    """Frequencies of the spectrum [Hz]."""
    amplitude: Float[np.ndarray, " bins"]
    """Amplitudes of the measured displacement [m]."""


def decay_of(run: Run, *, noise_sigma: float) -> RingDown:
    """The ring-down of a knock, as the frequency map has it.

    Args:
        run: A run with a knock and a camera.
        noise_sigma: Standard deviation of the camera's position [m].

    Returns:
        The ring-down.

    Raises:
        ValueError: If no vibration stands out.
    """
    margin = _CLOCK if run.clock_offset is None else _MARGIN
    return ring_down(
        run.camera.time,
        run.camera.position[:, 0],
        noise_sigma=noise_sigma,
        after=run.knock.start + run.knock.duration + (run.clock_offset or 0.0) + margin,
    )


def fitted_decay(
    time: Float[np.ndarray, " samples"],
    displacement: Float[np.ndarray, " samples"],
    decay: RingDown,
) -> FittedDecay:
    """The curve that a ring-down's frequencies and damping ratios stand for.

    Amplitudes, phases and drift follow from the samples by linear least squares.

    Args:
        time: Time of each sample [s].
        displacement: Horizontal displacement of the end-effector [m], NaN where lost.
        decay: The ring-down.

    Returns:
        Curve and spectrum.
    """
    first, last = decay.window
    used = np.isfinite(displacement) & (time >= first) & (time <= last)
    t, x = time[used], displacement[used]
    coefficients = np.linalg.lstsq(_basis(t - first, decay), x, rcond=None)[0]
    fine = np.linspace(first, last, 500)
    frequency, amplitude = amplitude_spectrum(t, x)
    return FittedDecay(fine, _basis(fine - first, decay) @ coefficients, frequency, amplitude)


def _basis(time: Float[np.ndarray, " n"], decay: RingDown) -> Float[np.ndarray, "n columns"]:
    columns = [np.ones_like(time), time]
    for mode in decay.modes:
        omega = 2 * np.pi * mode.frequency
        envelope = np.exp(-mode.damping_ratio * omega * time)
        turned = omega * np.sqrt(1 - mode.damping_ratio**2) * time
        columns += [envelope * np.cos(turned), envelope * np.sin(turned)]
    return np.stack(columns, axis=1)


@styled
def ring_down_figure(run: Run, decay: RingDown) -> Figure:
    """A knock's displacement with its fitted decay, and its spectrum.

    Args:
        run: The run; it has a camera.
        decay: Its ring-down.

    Returns:
        The figure.
    """
    time, displacement = run.camera.time, run.camera.position[:, 0]
    fitted = fitted_decay(time, displacement, decay)
    figure = new_figure(height=2.5)
    left, right = figure.subplots(1, 2, width_ratios=(2.2, 1))
    left.plot(
        time, 1e3 * displacement, "o", ms=2.8, color=BLUE, alpha=0.8, label="camera", zorder=3
    )
    left.plot(
        fitted.time, 1e3 * fitted.displacement, color=VERMILION, lw=1.4, label="fitted decay"
    )
    left.axvspan(*decay.window, color="#ececec", zorder=0, label="fitted window")
    left.set_xlabel(label("camera time", "s"))
    left.set_ylabel(label("xₑ", "mm"))
    legend_above(left)
    # Beyond four times the strongest mode there is noise alone.
    shown = fitted.frequency <= min(fitted.frequency[-1], 4 * decay.frequency)
    right.plot(fitted.frequency[shown], 1e3 * fitted.amplitude[shown], color=BLUE, lw=1.2)
    right.axvline(decay.frequency, color=VERMILION, lw=1.2)
    right.set_xlabel(label("frequency", "Hz"))
    right.set_ylabel(label("amplitude", "mm"))
    sigma = decay.frequency_sigma
    right.set_title(
        f"{rounded(decay.frequency, sigma)} ± {rounded(sigma, sigma)} Hz",
        color=VERMILION,
        fontsize=10,
    )
    right.set_ylim(bottom=0)
    right.axvline(decay.fft_frequency, color=GREY, ls=":", lw=1.2)
    return figure
