"""Bode plot of the open loop with its margins."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import plain
from experiments.studies.findings.responses import OpenLoop
from tuning.loop.margins import Margins


@style.styled
def bode(loop: OpenLoop, margins: Margins) -> Figure:
    """Gain and phase of a loop, its gain and phase margins marked.

    Args:
        loop: The loop.
        margins: Its margins.

    Returns:
        The figure.
    """
    figure, (above, below) = style.panels(2, 1, sharex=True, height=5.0, width=5.0)
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
    above.set(title="\n".join(titles), ylabel="gain [dB]")
    below.set(ylabel="phase [°]", xlabel="angular frequency [rad/s]")
    style.decades(below.xaxis)
    low = max(float(loop.phase.min()), -360.0)
    below.set_ylim(low - 10, loop.phase.max() + 20)
    return figure
