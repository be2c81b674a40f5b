"""Figures 13 and 14: experiment 1 of Table 2, and the torques of all four."""

from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.open_loop.numbers import TITLES, OpenLoop

_SERIES = (
    (0, "end-effector xₑ", style.BLUE),
    (2, "lower carriage q₃", style.VERMILION),
    (3, "upper carriage q₄", style.GREEN),
)


@style.styled
def draw_fig13(runs: OpenLoop) -> Figure:
    """Positions of experiment 1, and how far the end-effector lags.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure, (position, apart) = style.panels(1, 2, height=3.4)
    first = runs.position[0]
    for column, name, colour in _SERIES:
        position.plot(
            *style.thinned(runs.time, 1e3 * first[:, column]), color=colour, label=name
        )
        if column != 2:
            apart.plot(
                *style.thinned(runs.time, 1e3 * (first[:, column] - first[:, 2])), color=colour
            )
    position.set(ylabel="position [mm]")
    apart.set(ylabel="xₑ − q₃, q₄ − q₃ [mm]", title="behind the lower carriage")
    for axes in (position, apart):
        axes.axvline(1.0, color=style.GREY, lw=0.8, ls="--")
        axes.set_xlabel("time [s]")
    style.legend_above(position, columns=2)
    return figure


@style.styled
def draw_fig14(runs: OpenLoop) -> Figure:
    """Torques of the four experiments, as the drives give them.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure, panels = style.panels(1, 4, sharey=True, height=2.6)
    for axes, torque, title in zip(panels, runs.torque, TITLES, strict=True):
        for motor, (colour, dashes) in enumerate(((style.BLUE, "-"), (style.VERMILION, "--"))):
            axes.plot(
                *style.thinned(runs.time, torque[:, motor]),
                color=colour,
                ls=dashes,
                label=f"τ{'₁₂'[motor]}",
            )
        axes.set(title=title, xlabel="time [s]")
    panels[0].set_ylabel("torque [N m]")
    style.figure_legend(figure, panels[0])
    return figure


@style.styled
def draw_table2(runs: OpenLoop) -> Figure:
    """Where the end-effector goes in the four experiments.

    Args:
        runs: The runs.

    Returns:
        The figure.
    """
    figure, panels = style.panels(1, 4, height=2.8)
    for index, (axes, title) in enumerate(zip(panels, TITLES, strict=True)):
        column = 0 if index < 2 else 4
        axes.plot(
            *style.thinned(runs.time, 1e3 * runs.position[index, :, column]), color=style.BLUE
        )
        axes.axvline(1.0, color=style.GREY, lw=0.8, ls="--")
        axes.set(title=title, xlabel="time [s]", ylabel=f"{'xₑ' if index < 2 else 'yₑ'} [mm]")
    return figure
