"""Bode plot of the open loop with its margins."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import plain
from scdpr_jax.command.controller import PD
from tuning.loop.margins import Margins
from tuning.loop.plant import MotorPlant
from tuning.loop.responses import sampled_loop

_POINTS = 400
_LOWEST = 1e-2  # of the gain crossover
_HIGHEST = 0.9  # of the Nyquist frequency, where a sampled gain falls to nothing


class OpenLoop(NamedTuple):
    """Frequency response of the loop as the controller runs it."""

    angular_frequency: Float[np.ndarray, " points"]
    """Angular frequency [rad/s], up to near the Nyquist frequency."""
    gain: Float[np.ndarray, " points"]
    """Gain [dB]."""
    phase: Float[np.ndarray, " points"]
    """Phase, without jumps [°]."""


def open_loop(plant: MotorPlant, controller: PD, *, delay: int, crossover: float) -> OpenLoop:
    """The sampled open loop over frequency.

    Args:
        plant: The drive.
        controller: The controller.
        delay: Samples from a measurement to its command.
        crossover: Gain crossover, around which the plot is placed [rad/s].

    Returns:
        Gain and phase.
    """
    nyquist = np.pi / float(controller.period)
    omega = jnp.asarray(np.geomspace(_LOWEST * crossover, _HIGHEST * nyquist, _POINTS))
    over = jax.jit(jax.vmap(lambda w: sampled_loop(plant, controller, w, delay=delay)))
    response = np.asarray(over(omega))
    phase = np.degrees(np.unwrap(np.angle(response)))
    # The lowest frequency is integrated once: its phase is near -90 degrees.
    phase -= 360 * np.round((phase[0] + 90) / 360)
    return OpenLoop(np.asarray(omega), 20 * np.log10(np.abs(response)), phase)


@style.styled
def bode(loop: OpenLoop, margins: Margins) -> Figure:
    """Gain and phase of a loop, its gain and phase margins marked.

    Args:
        loop: The loop.
        margins: Its margins.

    Returns:
        The figure.
    """
    figure = style.new_figure(height=4.4, width=9.0)
    above, below = figure.subplots(2, 1, sharex=True)
    above.semilogx(loop.angular_frequency, loop.gain, color=style.BLUE)
    below.semilogx(loop.angular_frequency, loop.phase, color=style.BLUE)
    above.axhline(0, color=style.GREY, lw=0.8)
    below.axhline(-180, color=style.GREY, lw=0.8)
    at_gain, at_phase = float(margins.gain_crossover), float(margins.phase_crossover)
    phase_margin = float(np.degrees(margins.phase_margin))
    gain_margin = float(20 * np.log10(margins.gain_margin))
    titles = []
    if np.isfinite(at_gain):
        for axes in (above, below):
            axes.axvline(at_gain, color=style.VERMILION, ls=":", lw=1.2)
        below.plot([at_gain] * 2, [-180, -180 + phase_margin], color=style.VERMILION, lw=4)
        titles.append(f"phase margin {plain(phase_margin, 3)}° at {plain(at_gain, 3)} rad/s")
    if np.isfinite(at_phase):
        for axes in (above, below):
            axes.axvline(at_phase, color=style.BLACK, ls=":", lw=1.2)
        above.plot([at_phase] * 2, [-gain_margin, 0], color=style.BLACK, lw=4)
        titles.append(f"gain margin {plain(gain_margin, 3)} dB at {plain(at_phase, 3)} rad/s")
    above.set(title=";  ".join(titles), ylabel="gain [dB]")
    below.set(ylabel="phase [°]", xlabel="angular frequency [rad/s]")
    low = max(float(loop.phase.min()), -360.0)
    below.set_ylim(low - 10, loop.phase.max() + 20)
    return figure
