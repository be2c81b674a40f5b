"""Margins of the flexible robot's loops over the height of the end-effector."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style
from tuning.loop.flexible_loop import JOINT_LOOPS, LIFTING, UPPER_FREE
from tuning.loop.worst_margins import MarginMap

_SAFE_PHASE, _SAFE_PEAK = 30.0, 2.0
"""Phase margin [°] and peak sensitivity [1] short of which a loop rings (Åström, Hägglund)."""


@style.styled
def margin_curves(margin_map: MarginMap) -> Figure:
    """Phase margin and peak sensitivity over height, a colour for each pretension.

    Args:
        margin_map: The map.

    Returns:
        The figure.
    """
    figure, (left, right) = style.panels(1, 2, height=4.0)
    margins = margin_map.flexible.margins
    _curves(left, margin_map, np.degrees(np.asarray(margins.phase_margin)))
    _curves(right, margin_map, np.asarray(margins.peak_sensitivity))
    left.axhline(_SAFE_PHASE, color=style.GREY, ls=":", lw=1.2)
    right.axhline(_SAFE_PEAK, color=style.GREY, ls=":", lw=1.2)
    left.set(ylabel="phase margin [°]", ylim=(0, None))
    right.set(ylabel="peak sensitivity [1]", ylim=(1, None))
    style.figure_legend(figure, left, columns=4)
    return figure


def _curves(
    axes: Axes, margin_map: MarginMap, values: Float[np.ndarray, "loops settings heights"]
) -> None:
    height = 1e3 * margin_map.height
    for loop, rows in zip(JOINT_LOOPS, values, strict=True):
        if loop is LIFTING:
            # It has no stiffness, and no pretension: one line for all.
            axes.plot(height, rows[0], color=style.BLACK, lw=2.5, alpha=0.6, label=loop.name)
            continue
        for number, (setting, row) in enumerate(zip(margin_map.pretension, rows, strict=True)):
            axes.plot(
                height,
                row,
                color=style.CYCLE[number % len(style.CYCLE)],
                ls="-" if loop is UPPER_FREE else "--",
                label=f"{loop.name}, {setting:g} N",
            )
    axes.set_xlabel("yₑ [mm]")
