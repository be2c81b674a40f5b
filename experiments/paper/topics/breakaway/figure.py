"""Figure 10: the upper carriage at the printed voltage, and the staircases' histogram."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.breakaway.numbers import PRINTED_VOLTAGE, START, STEP, Breakaway

_DRAWN = 10
_SHOWN = 4.0  # s


@style.styled
def draw_fig10(loose: Breakaway, tight: Breakaway) -> Figure:
    """The first ten repetitions, and the voltages of all thirty.

    Args:
        loose: With the friction that staircases of the printed mean ask for.
        tight: With the friction of the printed voltage.

    Returns:
        The figure.
    """
    figure, (run, histogram) = style.panels(1, 2, height=3.4)
    shown = loose.time <= _SHOWN
    for repeat in range(_DRAWN):
        run.plot(
            *style.thinned(loose.time[shown], 1e3 * loose.upper[repeat, shown], points=200),
            color=style.SKY,
            lw=1.0,
            label="ten repetitions" if repeat == 0 else None,
        )
    middle = np.median(loose.upper[:, shown], axis=0)
    run.plot(
        *style.thinned(loose.time[shown], 1e3 * middle, points=200),
        color=style.BLACK,
        label="median of 30",
    )
    run.axhline(1e3 * START, color=style.GREY, lw=0.8)
    run.set(xlabel="time [s]", ylabel=f"q₄ at {PRINTED_VOLTAGE} V on both drives [mm]")
    style.legend_above(run)
    stairs = np.arange(0.4, 1.2, STEP)
    for numbers, colour, shift in (
        (loose, style.BLUE, -0.018),
        (tight, style.VERMILION, 0.018),
    ):
        count = [np.sum(np.isclose(numbers.voltage, v)) for v in stairs]
        histogram.bar(
            stairs + shift,
            count,
            width=0.034,
            color=colour,
            label=f"friction {numbers.force:.1f} N: mean {numbers.mean:.2f} V",
        )
    histogram.axvline(PRINTED_VOLTAGE, color=style.BLACK, ls="--", lw=1, label="printed mean")
    histogram.set(
        xlabel="first voltage that moves the upper carriage [V]", ylabel="repetitions of 30"
    )
    style.legend_above(histogram, columns=1)
    return figure
