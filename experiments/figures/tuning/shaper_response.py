"""What a shaper leaves of a vibration, over the vibration's frequency."""

import itertools
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.studies.findings.responses import NamedShaper

_POINTS = 500
_STYLES = (
    (style.BLUE, "-"),
    (style.VERMILION, "--"),
    (style.GREEN, "-."),
    (style.PURPLE, ":"),
    (style.ORANGE, "-"),
    (style.SKY, "--"),
)


@style.styled
def shaper_response(shapers: Sequence[NamedShaper], *, tolerance: float = 0.05) -> Figure:
    """Residual vibration over frequency, and the impulses.

    Args:
        shapers: The shapers; the band of each is shaded.
        tolerance: Residual vibration to draw a line at [1].

    Returns:
        The figure.
    """
    low = 0.5 * min(named.band[0] for named in shapers)
    high = 1.5 * max(named.band[1] for named in shapers)
    frequency = np.linspace(low, high, _POINTS)
    figure, (left, right) = style.panels(1, 2, widths=(1.4, 1.0), width=8.6, height=3.6)
    highest = 100.0
    for (color, dashes), named in zip(itertools.cycle(_STYLES), shapers, strict=False):
        curve = 100 * named.residual(frequency)
        highest = max(highest, float(curve.max()))
        left.plot(frequency, curve, color=color, ls=dashes, label=named.name)
        left.axvspan(*named.band, color=color, alpha=0.15, lw=0)
        left.axvline(sum(named.band) / 2, color=color, lw=0.8, alpha=0.7)
        times = 1e3 * np.asarray(named.shaper.times)
        amplitudes = np.asarray(named.shaper.amplitudes)
        stems = right.vlines(times, 0, amplitudes, color=color, lw=2.5)
        stems.set_linestyle(dashes)
        right.plot(times, amplitudes, "o", color=color, ms=5)
    left.axhline(100 * tolerance, color="#999999", ls=(0, (2, 2)), lw=1)
    left.set(
        ylim=(0, 1.05 * highest),
        xlim=(low, high),
        xlabel="frequency of the vibration [Hz]",
        ylabel="residual vibration [%]",
    )
    right.axhline(0, color="#999999", lw=0.8)
    right.set(xlabel="time [ms]", ylabel="impulse amplitude [1]")
    style.figure_legend(figure, left, columns=2)
    return figure
