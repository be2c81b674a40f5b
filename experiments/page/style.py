"""How every figure looks: colours, sizes, labels and legends, and no global state.

Figures are made as objects, never through a plotting session, and the settings hold only
while a function decorated with `styled` runs.
"""

import functools
from collections.abc import Callable, Sequence
from typing import ParamSpec, TypeVar

import matplotlib
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from experiments.page import theme
from experiments.page.number_text import plain

BLACK, GREY = theme.INK.day, theme.GREY.day
ORANGE, SKY, GREEN = theme.ORANGE.day, theme.SKY.day, theme.GREEN.day
BLUE, VERMILION, PURPLE = theme.BLUE.day, theme.VERMILION.day, theme.PURPLE.day
"""What figures are drawn in, by day: `themed` makes them fit for the night, too."""

RED_WORDS = theme.RED_WORDS.day
"""Vermilion for words."""

CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
"""Colours of unnamed series, in order."""

WIDTH = 10.0
"""Width of a figure [inch]; the page scales it to its column."""

DRAWN_POINTS = 700
"""Points of a drawn line: more than a column of the page has pixels to show."""

WORDS_ON_COLOURS = {
    "boxstyle": "round,pad=0.15",
    "facecolor": "white",
    "edgecolor": "none",
    "alpha": 0.85,
}
"""What is behind words on a map: a stroke about letters would cover the line above, and by
night leaves white ones on yellow."""

_PHONE, _HANDLE, _LETTER = 345.0, 42.0, 6.2
"""Widths of a phone's column, of a legend's handle with its gaps and of a letter [points]."""

_SETTINGS = {
    "font.family": "sans-serif",
    "font.size": 10.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    # Nothing is above the panels, so titles needn't look for their place.
    "axes.titley": 1.0,
    "axes.labelsize": 10.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": BLACK,
    "axes.titlecolor": BLACK,
    "text.color": BLACK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "axes.unicode_minus": True,
    "grid.color": theme.GRID.day,
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": BLACK,
    "ytick.labelcolor": BLACK,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    # Text stays text: it can be read aloud, searched for and copied.
    "svg.fonttype": "none",
    "path.simplify": True,
    # A third of a pixel at most, below what a line's own width hides.
    "path.simplify_threshold": 0.3,
}

_P = ParamSpec("_P")
_T = TypeVar("_T")


def styled(draw: Callable[_P, _T]) -> Callable[_P, _T]:
    """A drawing function whose figures have this style, whatever the caller has set.

    Args:
        draw: The function.

    Returns:
        The same function; the caller's settings are as before once it returns.
    """

    @functools.wraps(draw)
    def drawn(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        with matplotlib.rc_context(_SETTINGS):
            return draw(*args, **kwargs)

    return drawn


def new_figure(*, height: float, width: float = WIDTH) -> Figure:
    """An empty figure that lays itself out.

    Args:
        height: Height [inch].
        width: Width [inch].

    Returns:
        The figure, with a canvas of its own.
    """
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def label(name: str, unit: str) -> str:
    """An axis label.

    Args:
        name: What is drawn.
        unit: Its unit, "1" for none.

    Returns:
        "name [unit]".
    """
    return f"{name} [{unit}]"


def panels(
    rows: int,
    columns: int,
    *,
    height: float,
    width: float = WIDTH,
    widths: tuple[float, ...] | None = None,
    sharex: bool = False,
    sharey: bool = False,
) -> tuple[Figure, np.ndarray]:
    """An empty figure with its panels, row after row.

    Args:
        rows: Rows of panels.
        columns: Columns of panels.
        height: Height of the figure [inch].
        width: Width of the figure [inch].
        widths: The columns' widths in relation to each other; all the same by default.
        sharex: Whether all have the same horizontal axis.
        sharey: Whether all have the same vertical axis.

    Returns:
        The figure and its axes.
    """
    figure = new_figure(height=height, width=width)
    grid = figure.subplots(
        rows, columns, width_ratios=widths, sharex=sharex, sharey=sharey, squeeze=False
    )
    if columns > 1:
        # On a phone each panel stands by itself.
        for axes in grid.ravel():
            axes.xaxis.set_tick_params(labelbottom=True)
            axes.yaxis.set_tick_params(labelleft=True)
    return figure, grid.ravel()


def one_digit(value: float, _: int | None = None) -> str:
    """A tick's label with one digit, whatever its size.

    Args:
        value: The tick's place.

    Returns:
        The label.
    """
    return plain(value, 1)


def decades(axis: Axis, *, ticks: int = 6) -> None:
    """Name a logarithmic axis's decades as numbers: a power's digits are too small for a phone.

    Args:
        axis: The axis.
        ticks: Ticks at most; fewer decades than that have one each.
    """
    axis.set_major_locator(LogLocator(numticks=ticks))
    axis.set_major_formatter(one_digit)
    axis.set_minor_locator(NullLocator())


def legend_above(axes: Axes, *, columns: int = 4) -> None:
    """A legend above the axes, where it can't cover data.

    Args:
        axes: Axes with labelled artists; without any nothing is drawn.
        columns: Entries a row.
    """
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(
            handles,
            labels,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=fitting_columns(labels, columns),
            borderaxespad=0.2,
            handlelength=1.6,
            columnspacing=1.2,
        )


def figure_legend(figure: Figure, axes: Axes, *, columns: int = 5) -> None:
    """One legend above all panels of a figure, from those of one panel.

    Args:
        figure: The figure.
        axes: The panel whose labelled artists stand for all.
        columns: Entries a row.
    """
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper right", ncols=fitting_columns(labels, columns)
    )


def fitting_columns(labels: Sequence[str], most: int) -> int:
    """Columns of a legend that a phone shows letter for pixel.

    Args:
        labels: What its entries are called.
        most: Columns at most.

    Returns:
        As many as are no wider than a panel, one at least.
    """
    for columns in range(most, 1, -1):
        # Entries go down the columns, the first of which are the longer ones.
        stacks = np.array_split([len(label) for label in labels], columns)
        if sum(_HANDLE + _LETTER * stack.max(initial=0) for stack in stacks) <= _PHONE:
            return columns
    return 1


def thinned(
    x: Float[np.ndarray, " n"],
    y: Float[np.ndarray, " n"],
    *,
    points: int = DRAWN_POINTS,
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    """A dense series with fewer points that looks the same: each stretch's extremes.

    Args:
        x: Abscissae, increasing.
        y: Ordinates; NaN is kept out.
        points: Points that are left, about.

    Returns:
        Abscissae and ordinates, in order; unchanged if there are few already.
    """
    x, y = np.asarray(x), np.asarray(y)
    if len(x) <= points:
        return x, y
    kept = {0, len(x) - 1}
    for stretch in np.array_split(np.arange(len(x)), max(points // 2, 1)):
        finite = stretch[np.isfinite(y[stretch])]
        if finite.size:
            kept |= {int(finite[np.argmin(y[finite])]), int(finite[np.argmax(y[finite])])}
    index = np.array(sorted(kept))
    return x[index], y[index]
