"""How well every channel of every run is explained, on one page."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from experiments.page import style
from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import plain
from identification.fit.comparison import ENCODERS, Comparison

_LIGHTEST, _DARKEST = 1.0, 1e4  # mean squares between which the colour changes
_LARGE = 1e4  # from here on as a power of ten
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_SHADES = LinearSegmentedColormap.from_list(
    "misfit", ["#f4f8fb", "#f6c177", "#b5400a", "#4a1200"]
)


def misfits(
    comparisons: Sequence[Comparison],
) -> tuple[Float[np.ndarray, "runs 7"], Bool[np.ndarray, "runs 7"]]:
    """Mean squared residual of each run's channels over the noise's variance.

    Args:
        comparisons: The runs.

    Returns:
        The mean squares [1] in the order of `COORDINATES`, NaN where nothing was
        measured; and whether each may be noise alone.
    """
    square = np.full((len(comparisons), len(COORDINATES)), np.nan)
    noise = np.zeros(square.shape, dtype=bool)
    for row, comparison in enumerate(comparisons):
        for channel in comparison.channels:
            column = list(COORDINATES).index(channel.name)
            square[row, column] = channel.chi_square
            noise[row, column] = channel.is_noise
    return square, noise


@style.styled
def fit_overview(comparisons: Sequence[Comparison]) -> Figure:
    """A table of runs and channels: the mean squared residual in units of the noise.

    A cell that is more than noise has bold figures and a thick frame, besides its colour.

    Args:
        comparisons: The runs.

    Returns:
        The figure.
    """
    square, noise = misfits(comparisons)
    rows, columns = square.shape
    figure, (axes,) = style.panels(1, 1, height=1.1 + 0.29 * rows, width=9.0)
    norm = LogNorm(_LIGHTEST, _DARKEST, clip=True)
    # Frames last, so that no neighbour covers them.
    for row, column in sorted(np.ndindex(rows, columns), key=lambda at: not noise[at]):
        value = square[row, column]
        if not np.isfinite(value):
            axes.text(column + 0.5, row + 0.5, "–", ha="center", va="center", color="#a0a0a0")
            continue
        shade = _SHADES(norm(max(value, _LIGHTEST)))
        plain_cell = bool(noise[row, column])
        axes.add_patch(
            Rectangle(
                (column + 0.04, row + 0.06),
                0.92,
                0.88,
                facecolor=shade,
                edgecolor="#c9d3da" if plain_cell else style.BLACK,
                lw=0.6 if plain_cell else 2.0,
            )
        )
        dark = norm(max(value, _LIGHTEST)) > 0.45
        axes.text(
            column + 0.5,
            row + 0.5,
            _short(value),
            ha="center",
            va="center",
            fontsize=9,
            weight="normal" if plain_cell else "bold",
            color="white" if dark else style.BLACK,
        )
    _ticks(figure, axes, comparisons)
    return figure


def _ticks(figure, axes, comparisons: Sequence[Comparison]) -> None:
    axes.set(xlim=(0, len(COORDINATES)), ylim=(len(comparisons), 0))
    symbols = [
        f"{coordinate.symbol}\n{'encoder' if name in ENCODERS else 'camera'}"
        for name, coordinate in COORDINATES.items()
    ]
    axes.set_xticks(np.arange(len(symbols)) + 0.5, symbols, fontsize=10)
    names = [
        f"{comparison.name}  (not fitted)" if comparison.held_out else comparison.name
        for comparison in comparisons
    ]
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    for text, comparison in zip(axes.get_yticklabels(), comparisons, strict=True):
        if comparison.held_out:
            text.set_color(style.VERMILION)
            text.set_weight("bold")
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    handles = [
        Patch(facecolor="#f4f8fb", edgecolor="#c9d3da", label="may be the sensor's noise"),
        Patch(
            facecolor="#f6c177",
            edgecolor=style.BLACK,
            lw=2,
            label="more than noise (bold, framed)",
        ),
    ]
    figure.legend(handles=handles, loc="outside upper right", ncols=2)


def _short(value: float) -> str:
    """A mean square that fits its cell."""
    if value < _LARGE:
        return plain(value)
    digits, exponent = f"{value:.1e}".split("e")
    return digits + "·10" + str(int(exponent)).translate(_RAISED)
