"""Figures 11 and 12: a knock with its spectrum, and natural frequencies over the height."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
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

_COLOURS = (style.BLUE, style.GREEN, style.VERMILION, style.ORANGE, style.SKY, style.PURPLE)
_HIGHEST = 10.0  # Hz, of the drawn spectrum: the camera sees up to 15 Hz


@style.styled
def draw_fig11(knock: Knock) -> Figure:
    """A knock, its spectrum and the peak.

    Args:
        knock: The numbers.

    Returns:
        The figure.
    """
    figure, (record, spectrum) = style.panels(1, 2, height=3.2)
    record.plot(knock.time, 1e3 * knock.displacement, "o-", ms=2.5, lw=1.0, color=style.BLUE)
    record.set(
        xlabel="time [s]",
        ylabel="xₑ about its mean [mm]",
        title="end-effector after the knock, 30 frames a second",
    )
    shown = knock.frequency <= _HIGHEST
    spectrum.plot(knock.frequency[shown], 1e3 * knock.amplitude[shown], color=style.BLUE)
    peak = knock.peak
    spectrum.plot(peak.frequency, 1e3 * peak.amplitude, "o", color=style.VERMILION)
    spectrum.annotate(
        f"{peak.frequency:.2f} Hz",
        (peak.frequency, 1e3 * peak.amplitude),
        xytext=(8, -4),
        textcoords="offset points",
        color=style.VERMILION,
    )
    spectrum.set(
        xlabel="frequency [Hz]",
        ylabel="amplitude [mm]",
        title="its amplitude spectrum",
        ylim=(0, None),
    )
    return figure


@style.styled
def draw_fig12(numbers: Fig12) -> Figure:
    """First mode over the height for each carriage condition, and the simulated knocks.

    Args:
        numbers: The numbers.

    Returns:
        The figure, a panel for each pretension.
    """
    figure, panels = style.panels(1, len(SETTINGS), sharey=True, height=4.0)
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
            color=style.BLACK,
            label="simulated knocks, peak of the FFT",
            zorder=3,
        )
        if setting in MEASURED:
            axes.axhline(MEASURED[setting], color=style.GREY, ls="--", label="reported level")
        axes.set(title=f"nominal {setting:.0f} N", xlabel="yₑ [mm]", ylim=(0, 6))
    panels[0].set_ylabel("natural frequency [Hz]")
    style.figure_legend(figure, panels[0], columns=2)
    return figure
