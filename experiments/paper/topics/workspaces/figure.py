"""Figures 3 and 6: the conventional robot's static workspace beside the single loop's."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.page import style
from experiments.paper.topics.workspaces.numbers import PRINTED, Workspaces

_LEVELS = (50, 75, 100, 150, 200, 300, 500)
_COLOURS = (style.BLUE, style.GREEN, style.VERMILION, style.ORANGE)
_MOST = 500.0  # N, of the drawn tensions


@style.styled
def draw_fig3(numbers: Workspaces) -> Figure:
    """Where the conventional robot can stand, by the largest tension that it needs.

    Args:
        numbers: The workspaces.

    Returns:
        The figure: four maps.
    """
    figure, panels = style.panels(4, 1, height=12.5, width=5.0)
    for axes, cables in zip(panels, numbers.cables, strict=True):
        needed = np.where(np.isfinite(cables.needed), cables.needed, np.nan)
        filled = axes.contourf(
            1e3 * numbers.x, 1e3 * numbers.y, needed.T, levels=(0, *_LEVELS), cmap="viridis_r"
        )
        _frame(axes, numbers)
        axes.set_title(cables.name)
        printed = PRINTED[cables.minimum]
        maximum = cables.maximum_for(printed)
        requirement = (
            f"{100 * printed:.2f} % needs T_max {maximum:.0f} N"
            if np.isfinite(maximum)
            else f"{100 * printed:.2f} % at no T_max: {100 * cables.share(1e9):.1f} % at most"
        )
        axes.set_xlabel(requirement)
    bar = figure.colorbar(
        filled, ax=list(panels), orientation="horizontal", shrink=0.9, pad=0.01, aspect=30
    )
    bar.set_label("T_max that a pose needs [N]")
    return figure


@style.styled
def draw_fig6(numbers: Workspaces) -> Figure:
    """The single loop's workspace, and both robots' shares over the largest tension.

    Args:
        numbers: The workspaces.

    Returns:
        The figure: a map and a diagram.
    """
    figure, (map_, curve) = style.panels(1, 2, height=3.4)
    low, high = (
        1e3 * np.asarray(corner) for corner in (numbers.loop.lowest, numbers.loop.highest)
    )
    map_.add_patch(Rectangle(tuple(low), *(high - low), color=style.BLUE, alpha=0.35))
    _frame(map_, numbers)
    map_.set(
        title=f"Eq. (1): {100 * numbers.loop_share:.1f} % of the frame's area", xlabel="xₑ [mm]"
    )
    maximum = np.linspace(0, _MOST, 200)
    for cables, colour in zip(numbers.cables, _COLOURS, strict=True):
        share = [100 * cables.reachable_share(tension) for tension in maximum]
        curve.plot(maximum, share, color=colour, label=cables.name)
    curve.axhline(
        100 * numbers.loop_reachable,
        color=style.BLACK,
        ls="--",
        label="single loop, any tension",
    )
    curve.set(xlabel="T_max [N]", ylabel="share of reachable poses [%]")
    style.legend_above(curve, columns=2)
    return figure


def _frame(axes: Axes, numbers: Workspaces) -> None:
    step_x, step_y = numbers.x[0], numbers.y[0]
    size = (1e3 * (numbers.x[-1] + step_x), 1e3 * (numbers.y[-1] + step_y))
    axes.add_patch(Rectangle((0, 0), *size, fill=False, lw=2, edgecolor=style.GREY))
    axes.set(xlim=(-20, size[0] + 20), ylim=(-20, size[1] + 20), aspect="equal")
    axes.grid(visible=False)
    axes.set_ylabel("yₑ [mm]")
