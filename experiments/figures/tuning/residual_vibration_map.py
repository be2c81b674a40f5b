"""What the scheduled shapers leave of a vibration, over the workspace."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from experiments.page import style
from experiments.page.number_text import percent
from tuning.regions.residual_map import ResidualMap
from tuning.result.regional_shaper import Region

_LEAST_SCALE = 0.05
"""Least end of the colours' scale [1]: what is left below a twentieth is all good."""
_LEVELS = MaxNLocator(10)
"""Round levels, some ten of them."""


@style.styled
def residual_vibration_map(
    maps: Sequence[ResidualMap], regions: Sequence[Sequence[Region]]
) -> Figure:
    """Residual vibration after legs that end at a pose, a panel for each pretension.

    Args:
        maps: The maps, one at least.
        regions: The shapers' regions at each map's pretension.

    Returns:
        The figure.
    """
    figure, grid = style.panels(len(maps), 1, height=3.2 * len(maps) + 0.7, width=5.0)
    highest = max(_LEAST_SCALE, *(one.worst.value for one in maps))
    # Rounded, or 100 % and a rounding would take a level more.
    levels = _LEVELS.tick_values(0, round(100 * highest, 9))
    for axes, one, here in zip(grid, maps, regions, strict=True):
        # What that took off would be left white.
        left = np.minimum(100 * one.residual, levels[-1])
        filled = axes.contourf(1e3 * one.x, 1e3 * one.y, left, levels=levels, cmap="viridis")
        # Otherwise the page shines through between two colours.
        filled.set_edgecolor("face")
        _lines(axes, here)
        _worst(axes, one)
        axes.set(
            aspect="equal",
            xlim=(0, 1e3 * max(region.x[1] for region in here)),
            ylim=(0, 1e3 * max(region.y[1] for region in here)),
            xlabel="xₑ [mm]",
            ylabel="yₑ [mm]",
            title=f"nominal pretension {one.pretension:g} N",
        )
    bar = figure.colorbar(
        filled, ax=list(grid), orientation="horizontal", shrink=0.9, pad=0.02, aspect=30
    )
    bar.set_label("vibration left, at worst [%]")
    return figure


def _lines(axes: Axes, regions: Sequence[Region]) -> None:
    """The regions' inner edges, about which their shapers hand over."""
    for draw, spans in (
        (axes.axvline, {region.x for region in regions}),
        (axes.axhline, {region.y for region in regions}),
    ):
        for low in sorted(low for low, _ in spans)[1:]:
            draw(1e3 * low, color="white", ls="--", lw=1.2)


def _worst(axes: Axes, one: ResidualMap) -> None:
    value, x, y = one.worst
    axes.plot(
        1e3 * x, 1e3 * y, "X", ms=11, color=style.VERMILION, mec="white", mew=1.2, clip_on=False
    )
    right = x > np.mean(one.x)
    axes.annotate(
        f"worst: {percent(value, 3)}",
        (1e3 * x, 1e3 * y),
        xytext=(-10 if right else 10, 0),
        textcoords="offset points",
        ha="right" if right else "left",
        va="center",
        color=style.BLACK,
        bbox=style.WORDS_ON_COLOURS,
        zorder=4,
    )
