"""Move time against residual vibration, and the vibration of every model."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from experiments.page import style
from tuning.codesign import Designed

_COLOURS = (style.BLUE, style.VERMILION, style.ORANGE, style.GREEN)
_MARKERS = ("o", "s", "^", "D")


@style.styled
def pareto(
    fronts: Mapping[str, Sequence[Designed]],
    spreads: Mapping[str, Designed],
    *,
    chosen: Designed,
) -> Figure:
    """A front beside what it is compared with, and how the models are spread.

    Args:
        fronts: Designs by name, the co-design first.
        spreads: Designs on models that none of them has seen, by name.
        chosen: The design that is recommended.

    Returns:
        Left the front: mean of the worst tenth, thin above it the worst. Right the share of
        the models that vibrates less.
    """
    figure, (left, right) = style.panels(1, 2, height=4.4)
    dashes = dict(zip(fronts, zip(_COLOURS, _MARKERS, strict=False), strict=False))
    for name, designs in fronts.items():
        _front(left, name, designs, *dashes[name])
    left.plot(
        chosen.move_time,
        1e3 * chosen.vibration,
        "o",
        markersize=13,
        markerfacecolor="none",
        color=_COLOURS[0],
        label="recommended",
    )
    for name, one in spreads.items():
        value = np.sort(1e3 * np.asarray(one.measures.residual_vibration))
        # From no model on: a single one would be a point, which isn't drawn.
        value = np.append(value[:1], value)
        share = 100 * np.arange(value.size) / (value.size - 1)
        right.step(value, share, where="post", color=dashes[name][0])
    for axes in (left, right):
        axes.set_axisbelow(True)
    left.set_yscale("log")
    right.set_xscale("log")
    for axis in (left.yaxis, right.xaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(style.one_digit)
        axis.set_minor_locator(NullLocator())
    left.set(
        xlabel="move time with the shaper [s]",
        ylabel="vibration after the move, peak to peak [mm]",
    )
    right.set(
        xlabel="vibration of a model not seen before [mm]",
        ylabel="models that vibrate less [%]",
        ylim=(0, 101),
    )
    style.figure_legend(figure, left, columns=4)
    return figure


def _front(
    axes: Axes, name: str, designs: Sequence[Designed], colour: str, marker: str
) -> None:
    time = [one.move_time for one in designs]
    tail = [1e3 * one.vibration for one in designs]
    worst = [1e3 * float(np.max(one.measures.residual_vibration)) for one in designs]
    axes.plot(time, tail, color=colour, marker=marker, label=name)
    axes.plot(time, worst, color=colour, lw=0.8, ls=(0, (4, 3)))
