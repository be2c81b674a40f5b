"""Where the linear model holds, and when carriages stick."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.validity.numbers import (
    CAMERA,
    FORCES,
    HEIGHTS,
    TENSIONS,
    VOLTAGES,
    Validity,
)

_COLOURS = (style.ORANGE, style.VERMILION, style.GREEN, style.BLUE)
_TICKS = (2, 5, 10, 20, 50)  # N


@style.styled
def draw_linear_error(numbers: Validity) -> Figure:
    """Error of the linear model over pose, pretension and acceleration.

    Args:
        numbers: The errors.

    Returns:
        The figure: a panel for each pretension.
    """
    figure, panels = style.panels(1, len(TENSIONS), sharey=True, height=3.0)
    for axes, tension, error in zip(panels, TENSIONS, numbers.error, strict=True):
        for index, volts in enumerate(VOLTAGES):
            axes.semilogy(
                1e3 * np.array(HEIGHTS),
                1e3 * error[:, index],
                "o-",
                ms=3,
                label=f"{numbers.acceleration[index]:.1f} m/s² ({volts:g} V)",
            )
        axes.axhline(1e3 * CAMERA, color=style.GREY, ls="--", lw=1, label="camera")
        axes.set(title=f"T_eff {tension:g} N", xlabel="yₑ [mm]")
        style.decades(axes.yaxis)
    panels[0].set_ylabel("error of (18) [mm]")
    style.figure_legend(figure, panels[0], columns=6)
    return figure


@style.styled
def draw_sticking(numbers: Validity) -> Figure:
    """Share of the time after a knock in which the carriages rest.

    Args:
        numbers: The shares.

    Returns:
        The figure.
    """
    figure, panels = style.panels(1, 2, sharey=True, height=2.8)
    for axes, carriage in zip(panels, (0, 1), strict=True):
        for tension, share, colour in zip(TENSIONS, numbers.sticking, _COLOURS, strict=True):
            axes.semilogx(
                FORCES,
                100 * share[:, carriage],
                "o-",
                ms=3,
                color=colour,
                label=f"T_eff {tension:g} N",
            )
        axes.set_xlabel("force of the knock, 30 ms [N]")
        axes.set_xticks(_TICKS, [f"{force:g}" for force in _TICKS])
        axes.minorticks_off()
        axes.set(ylabel=f"{('lower', 'upper')[carriage]} carriage rests [%]", ylim=(0, 105))
        style.legend_above(axes, columns=2)
    return figure
