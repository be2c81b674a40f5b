"""Where the linear model holds, and when carriages stick."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    VERMILION,
    figure_legend,
    label,
    legend_above,
    new_figure,
    styled,
)
from experiments.paper.topics.validity.numbers import (
    CAMERA,
    FORCES,
    HEIGHTS,
    TENSIONS,
    VOLTAGES,
    Validity,
)

_COLOURS = (ORANGE, VERMILION, GREEN, BLUE)
_TICKS = (2, 5, 10, 20, 50)  # N


@styled
def draw_linear_error(numbers: Validity) -> Figure:
    """Error of the linear model over pose, pretension and acceleration.

    Args:
        numbers: The errors.

    Returns:
        The figure: a panel for each pretension.
    """
    figure = new_figure(height=3.0)
    panels = figure.subplots(1, len(TENSIONS), sharey=True)
    for axes, tension, error in zip(panels, TENSIONS, numbers.error, strict=True):
        for index, volts in enumerate(VOLTAGES):
            axes.semilogy(
                1e3 * np.array(HEIGHTS),
                1e3 * error[:, index],
                "o-",
                ms=3,
                label=f"{numbers.acceleration[index]:.1f} m/s² ({volts:g} V)",
            )
        axes.axhline(1e3 * CAMERA, color=GREY, ls="--", lw=1, label="camera")
        axes.set_title(f"T_eff {tension:g} N")
        axes.set_xlabel(label("yₑ", "mm"))
    panels[0].set_ylabel(label("error of (18)", "mm"))
    figure_legend(figure, panels[0], columns=6)
    return figure


@styled
def draw_sticking(numbers: Validity) -> Figure:
    """Share of the time after a knock in which the carriages rest.

    Args:
        numbers: The shares.

    Returns:
        The figure.
    """
    figure = new_figure(height=2.8)
    for axes, carriage in zip(figure.subplots(1, 2, sharey=True), (0, 1), strict=True):
        for tension, share, colour in zip(TENSIONS, numbers.sticking, _COLOURS, strict=True):
            axes.semilogx(
                FORCES,
                100 * share[:, carriage],
                "o-",
                ms=3,
                color=colour,
                label=f"T_eff {tension:g} N",
            )
        axes.set_xlabel(label("force of the knock, 30 ms", "N"))
        axes.set_xticks(_TICKS, [f"{force:g}" for force in _TICKS])
        axes.minorticks_off()
        axes.set_ylabel(label(f"{('lower', 'upper')[carriage]} carriage rests", "%"))
        axes.set_ylim(0, 105)
        legend_above(axes, columns=2)
    return figure
