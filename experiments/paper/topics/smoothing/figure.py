"""What smoothed friction costs a fit, by its width."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.smoothing.numbers import STEPS, SYMBOLS, WANTED, WIDTHS, Smoothing
from scdpr_jax.robot.parameters import SMOOTHING_WIDTH

_FITTED = (
    (style.BLUE, "o-", 2.5),
    (style.ORANGE, "s-", 1.0),
    (style.GREEN, "^-", 1.0),
    (style.PURPLE, "D-", 1.0),
)
_EXACT = ("--", ":")
_TICKS = (200, 500, 1000, 2000, 5000)


@style.styled
def draw_smoothing(numbers: Smoothing) -> Figure:
    """Bias of the estimates, error of the gradient and steps over the width.

    Args:
        numbers: The errors.

    Returns:
        The figure: what is off on the left, what it costs on the right.
    """
    figure, (off, cost) = style.panels(1, 2, widths=(1.1, 1.0), height=4.2, width=9.6)
    for name, values, (colour, line, width) in zip(
        SYMBOLS, 100 * np.abs(numbers.bias.T), _FITTED, strict=True
    ):
        off.loglog(WIDTHS, values, line, ms=4, color=colour, lw=width, label=f"bias of {name}")
    held = [100 * one.held for one in numbers.by_width]
    sliding = [100 * one.sliding for one in numbers.by_width]
    off.loglog(WIDTHS, held, "x--", ms=5, color=style.VERMILION, label="∂/∂μ, held")
    off.loglog(WIDTHS, sliding, "x--", ms=5, color=style.SKY, label="∂/∂μ, sliding")
    off.axhline(100 * WANTED, color=style.GREY, ls="-.", lw=1, label="wanted for μ")
    exact = 100 * abs(numbers.exact[-1].bias[0])
    off.axhline(
        exact, color=style.BLACK, ls=_EXACT[-1], label=f"bias of μ, {_engine(STEPS[-1])}"
    )
    off.set_ylabel("relative error [%]")
    steps = [one.steps for one in numbers.by_width]
    cost.loglog(WIDTHS, steps, "o-", ms=4, color=style.BLUE, label="smoothed, adaptive")
    for step, one, line in zip(STEPS, numbers.exact, _EXACT, strict=True):
        cost.axhline(one.steps, color=style.BLACK, ls=line, label=_engine(step))
    cost.set_yticks(_TICKS, [f"{steps}" for steps in _TICKS])
    cost.tick_params(axis="y", which="minor", left=False, labelleft=False)
    cost.set_ylabel("steps of a run [1]")
    for axes in (off, cost):
        _mark_default(axes)
        axes.set_xlabel("width vₛ of the friction [m/s]")
        style.decades(axes.xaxis)
    style.decades(off.yaxis)
    style.legend_above(off, columns=3)
    style.legend_above(cost, columns=2)
    return figure


def _engine(step: float) -> str:
    return f"exact, {1e3 * step:g} ms"


def _mark_default(axes: Axes) -> None:
    axes.axvline(SMOOTHING_WIDTH, color=style.GREY, lw=1, zorder=0)
    axes.annotate(
        "default",
        (SMOOTHING_WIDTH, 0.98),
        xycoords=axes.get_xaxis_transform(),
        xytext=(4, 0),
        textcoords="offset points",
        va="top",
    )
