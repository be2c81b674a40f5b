"""What every leg leaves: vibration and resting error, sorted."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from tuning.result.prediction import LegsOutcome

_STYLES = ((style.VERMILION, "-"), (style.BLUE, "-"), (style.GREEN, "--"))
_LEAST = 1e-3
"""Lengths below which they are drawn as this [mm]: a count of the encoders moves more."""


@style.styled
def legs_outcome(sides: Sequence[tuple[str, LegsOutcome]]) -> Figure:
    """The share of the legs that vibrate less, and that rest nearer to their target.

    Args:
        sides: Names and outcomes of up to three laws, the one before first.

    Returns:
        The figure.
    """
    figure, (left, right) = style.panels(1, 2, sharey=True, height=3.4)
    for (name, outcome), (color, dashes) in zip(sides, _STYLES, strict=False):
        for axes, values in ((left, outcome.vibration), (right, outcome.resting_error)):
            sorted_ = np.sort(np.maximum(1e3 * np.asarray(values), _LEAST))
            share = 100 * np.arange(1, sorted_.size + 1) / sorted_.size
            axes.step(sorted_, share, where="post", color=color, ls=dashes, lw=2, label=name)
    for axes, name in ((left, "vibration after the leg"), (right, "resting error")):
        axes.set(
            xscale="log", xlabel=f"{name} [mm]", ylabel="legs with less [%]", ylim=(0, 101)
        )
        axes.yaxis.set_tick_params(labelleft=True)
        style.decades(axes.xaxis)
    style.figure_legend(figure, left, columns=3)
    return figure
