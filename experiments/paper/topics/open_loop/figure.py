"""Figures 13 and 14: experiment 1 of Table 2, and the torques of all four."""

from matplotlib.figure import Figure

from experiments.page.style import (
    BLUE,
    GREEN,
    GREY,
    VERMILION,
    figure_legend,
    label,
    legend_above,
    new_figure,
    styled,
    thinned,
)
from experiments.paper.topics.open_loop.numbers import TITLES, OpenLoop

_SERIES = (
    (0, "end-effector xₑ", BLUE),
    (2, "lower carriage q₃", VERMILION),
    (3, "upper carriage q₄", GREEN),
)


@styled
def draw_fig13(runs: OpenLoop) -> Figure:
    """Positions of experiment 1, and how far the end-effector lags.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure = new_figure(height=3.4)
    position, apart = figure.subplots(1, 2)
    first = runs.position[0]
    for column, name, colour in _SERIES:
        position.plot(*thinned(runs.time, 1e3 * first[:, column]), color=colour, label=name)
        if column != 2:
            apart.plot(
                *thinned(runs.time, 1e3 * (first[:, column] - first[:, 2])), color=colour
            )
    position.set_ylabel(label("position", "mm"))
    apart.set_ylabel(label("xₑ − q₃, q₄ − q₃", "mm"))
    apart.set_title("behind the lower carriage")
    for axes in (position, apart):
        axes.axvline(1.0, color=GREY, lw=0.8, ls="--")
        axes.set_xlabel(label("time", "s"))
    legend_above(position, columns=2)
    return figure


@styled
def draw_fig14(runs: OpenLoop) -> Figure:
    """Torques of the four experiments, as the drives give them.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure = new_figure(height=2.6)
    panels = figure.subplots(1, 4, sharey=True)
    for axes, torque, title in zip(panels, runs.torque, TITLES, strict=True):
        for motor, (colour, style) in enumerate(((BLUE, "-"), (VERMILION, "--"))):
            axes.plot(
                *thinned(runs.time, torque[:, motor]),
                color=colour,
                ls=style,
                label=f"τ{'₁₂'[motor]}",
            )
        axes.set_title(title)
        axes.set_xlabel(label("time", "s"))
    panels[0].set_ylabel(label("torque", "N m"))
    figure_legend(figure, panels[0])
    return figure


@styled
def draw_table2(runs: OpenLoop) -> Figure:
    """Where the end-effector goes in the four experiments.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure = new_figure(height=2.8)
    panels = figure.subplots(1, 4)
    for index, (axes, title) in enumerate(zip(panels, TITLES, strict=True)):
        column = 0 if index < 2 else 4
        axes.plot(*thinned(runs.time, 1e3 * runs.position[index, :, column]), color=BLUE)
        axes.axvline(1.0, color=GREY, lw=0.8, ls="--")
        axes.set_title(title)
        axes.set_xlabel(label("time", "s"))
        axes.set_ylabel(label("xₑ" if index < 2 else "yₑ", "mm"))
    return figure
