"""Horizontal stiffness of both robots over the workspace."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page.style import (
    BLUE,
    GREEN,
    VERMILION,
    label,
    legend_above,
    new_figure,
    styled,
)
from experiments.paper.topics.stiffness.numbers import Stiffness


@styled
def draw_stiffness(numbers: Stiffness) -> Figure:
    """The single loop's over the height, the conventional robot's as a map.

    Args:
        numbers: The maps.

    Returns:
        The figure.
    """
    figure = new_figure(height=3.4)
    curve, map_ = figure.subplots(1, 2)
    middle = len(numbers.x) // 2
    for values, colour, name in (
        (numbers.conventional[middle], VERMILION, "four cables, mid-width"),
        (numbers.both_held, BLUE, "single loop, both carriages held"),
        (numbers.lower_held, GREEN, "single loop, upper carriage free"),
    ):
        curve.semilogy(1e3 * numbers.y, 1e-3 * values, color=colour, label=name)
    curve.set_xlabel(label("yₑ", "mm"))
    curve.set_ylabel(label("horizontal stiffness", "N/mm"))
    legend_above(curve, columns=2)
    ratio = numbers.conventional / np.nanmin(numbers.conventional)
    filled = map_.contourf(1e3 * numbers.x, 1e3 * numbers.y, ratio.T, levels=12, cmap="viridis")
    figure.colorbar(filled, ax=map_).set_label("over its smallest [1]")
    map_.set_title("four cables")
    map_.set_aspect("equal")
    map_.set_xlabel(label("xₑ", "mm"))
    map_.set_ylabel(label("yₑ", "mm"))
    return figure
