"""Figures 11 and 12: a knock with its spectrum, and natural frequencies over the height."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    figure_legend,
    label,
    new_figure,
    styled,
)
from experiments.paper.topics.knocks.numbers import (
    COLUMNS,
    HEIGHTS,
    MEASURED,
    ROWS,
    SETTINGS,
    Fig12,
    Knock,
    effective_share,
)
from scdpr_jax.linear.modes import BOTH_HELD

_COLOURS = (BLUE, GREEN, VERMILION, ORANGE, SKY, PURPLE)
_HIGHEST = 10.0  # Hz, of the drawn spectrum: the camera sees up to 15 Hz


@styled
def draw_fig11(knock: Knock) -> Figure:
    """A knock, its spectrum and the peak.

    Args:
        knock: The numbers.

    Returns:
        The figure.
    """
    figure = new_figure(height=3.2)
    record, spectrum = figure.subplots(1, 2)
    record.plot(knock.time, 1e3 * knock.displacement, "o-", ms=2.5, lw=1.0, color=BLUE)
    record.set_xlabel(label("time", "s"))
    record.set_ylabel(label("xₑ about its mean", "mm"))
    record.set_title("end-effector after the knock, 30 frames a second")
    shown = knock.frequency <= _HIGHEST
    spectrum.plot(knock.frequency[shown], 1e3 * knock.amplitude[shown], color=BLUE)
    peak = knock.peak
    spectrum.plot(peak.frequency, 1e3 * peak.amplitude, "o", color=VERMILION)
    spectrum.annotate(
        f"{peak.frequency:.2f} Hz",
        (peak.frequency, 1e3 * peak.amplitude),
        xytext=(8, -4),
        textcoords="offset points",
        color=VERMILION,
    )
    spectrum.set_xlabel(label("frequency", "Hz"))
    spectrum.set_ylabel(label("amplitude", "mm"))
    spectrum.set_title("its amplitude spectrum")
    spectrum.set_ylim(bottom=0)
    return figure


@styled
def draw_fig12(numbers: Fig12) -> Figure:
    """First mode over the height for each carriage condition, and the simulated knocks.

    Args:
        numbers: The numbers.

    Returns:
        The figure, a panel for each pretension.
    """
    figure = new_figure(height=4.0)
    panels = figure.subplots(1, len(SETTINGS), sharey=True)
    for index, (axes, setting) in enumerate(zip(panels, SETTINGS, strict=True)):
        tension = effective_share() * setting
        for level, colour in zip(numbers.levels, _COLOURS, strict=True):
            condition = level.condition
            axes.plot(
                1e3 * np.array(HEIGHTS),
                tension**0.5 * level.curve,
                color=colour,
                lw=2.2 if condition == BOTH_HELD else 1.2,
                label=f"lower {condition.lower.value}, upper {condition.upper.value}",
            )
        rows = 1e3 * np.repeat(ROWS, len(COLUMNS))
        axes.plot(
            rows,
            numbers.peaks[index].ravel(),
            "o",
            ms=5,
            color=BLACK,
            label="simulated knocks, peak of the FFT",
            zorder=3,
        )
        if setting in MEASURED:
            axes.axhline(MEASURED[setting], color=GREY, ls="--", label="reported level")
        axes.set_title(f"nominal {setting:.0f} N")
        axes.set_xlabel(label("yₑ", "mm"))
        axes.set_ylim(0, 6)
    panels[0].set_ylabel(label("natural frequency", "Hz"))
    figure_legend(figure, panels[0], columns=2)
    return figure
