"""How close each explanation comes to each reported result."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.explanation.numbers import REPORTED, Explanation

_SHOWN = 5.0  # sigmas, the end of the colours
_ROWS = 8


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
    figure, (axes,) = style.panels(1, 1, height=0.55 * len(shown) + 1.6)
    image = axes.imshow(
        deviations, cmap="RdBu_r", vmin=-_SHOWN, vmax=_SHOWN, aspect="auto", alpha=0.8
    )
    for (row, column), value in np.ndenumerate(deviations):
        reported = REPORTED[column]
        text = f"{shown[row].computed[column]:.3g} {reported.unit}"
        axes.text(column, row, text, ha="center", va="center", fontsize=9, color=style.BLACK)
        if abs(value) > 2:
            axes.texts[-1].set_fontweight("bold")
    axes.set_xticks(range(len(REPORTED)))
    names = (one.name.replace(", ", "\n").replace(" at ", "\nat ") for one in REPORTED)
    axes.set_xticklabels(
        [f"{name}\n{one.value:g} {one.unit}" for name, one in zip(names, REPORTED, strict=True)]
    )
    axes.tick_params(axis="x", labelsize=8)
    axes.set_yticks(range(len(shown)))
    axes.set_yticklabels([fit.hypothesis.name.replace("; ", "\n", 1) for fit in shown])
    axes.tick_params(axis="y", labelsize=8)
    axes.grid(visible=False)
    figure.colorbar(image, ax=axes, pad=0.01).set_label("computed − reported, over σ [1]")
    return figure
