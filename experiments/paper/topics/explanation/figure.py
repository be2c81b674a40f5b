"""How close each explanation comes to each reported result."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.explanation.numbers import REPORTED, Explanation

_SHOWN = 5.0  # sigmas, the end of the colours
_ROWS = 8
_BLACK = "#010101"  # on colours that are the same by night


@style.styled
def draw_explanations(fits: tuple[Explanation, ...]) -> Figure:
    """Deviations of the best fits, one a row.

    Args:
        fits: The fits, the best first.

    Returns:
        The figure.
    """
    shown = fits[:_ROWS]
    deviations = np.array([fit.deviations for fit in shown])
    figure, (axes,) = style.panels(1, 1, height=0.8 * len(shown) + 2.6, width=5.0)
    # Every row has its name above it: beside it there is no room on a phone.
    spaced = np.full((2 * len(shown), len(REPORTED)), np.nan)
    spaced[1::2] = deviations
    image = axes.imshow(
        spaced, cmap="RdBu_r", vmin=-_SHOWN, vmax=_SHOWN, aspect="auto", alpha=0.8
    )
    for row, fit in enumerate(shown):
        axes.text(-0.45, 2 * row, fit.hypothesis.name.replace("; ", "\n", 1), va="center")
    for (row, column), value in np.ndenumerate(deviations):
        number = f"{shown[row].computed[column]:.3g}"
        # Black on its colours, by night as by day.
        axes.text(column, 2 * row + 1, number, ha="center", va="center", color=_BLACK)
        if abs(value) > 2:
            axes.texts[-1].set_fontweight("bold")
    names = (one.name.replace(", ", "\n").replace(" at ", "\nat ") for one in REPORTED)
    axes.set_xticks(
        range(len(REPORTED)),
        [
            f"{name}\n{one.value:g} {one.unit}"
            for name, one in zip(names, REPORTED, strict=True)
        ],
        rotation=90,
    )
    axes.set_yticks([])
    axes.grid(visible=False)
    bar = figure.colorbar(image, ax=axes, orientation="horizontal", pad=0.02, aspect=30)
    bar.set_label("computed − reported, over σ [1]")
    return figure
