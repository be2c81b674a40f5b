"""Horizontal stiffness of both robots over the workspace."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.stiffness.numbers import Stiffness


@style.styled
def draw_stiffness(numbers: Stiffness) -> Figure:
    """The single loop's over the height, the conventional robot's as a map.

    Args:
        numbers: The maps.

    Returns:
        The figure.
    """
    figure, (curve, map_) = style.panels(2, 1, height=7.4, width=5.0)
    middle = len(numbers.x) // 2
    for values, colour, name in (
        (numbers.conventional[middle], style.VERMILION, "four cables, mid-width"),
        (numbers.both_held, style.BLUE, "single loop, both carriages held"),
        (numbers.lower_held, style.GREEN, "single loop, upper carriage free"),
    ):
        curve.semilogy(1e3 * numbers.y, 1e-3 * values, color=colour, label=name)
    style.decades(curve.yaxis)
    curve.set(xlabel="yₑ [mm]", ylabel="horizontal stiffness [N/mm]")
    style.legend_above(curve, columns=2)
    ratio = numbers.conventional / np.nanmin(numbers.conventional)
    filled = map_.contourf(1e3 * numbers.x, 1e3 * numbers.y, ratio.T, levels=12, cmap="viridis")
    bar = figure.colorbar(filled, ax=map_, orientation="horizontal", aspect=30)
    bar.set_label("over its smallest [1]")
    map_.set(title="four cables", aspect="equal", xlabel="xₑ [mm]", ylabel="yₑ [mm]")
    return figure
