"""Which parameters the data can only tell together."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.page import style

_SHADES = LinearSegmentedColormap.from_list(
    "correlation", ["#0072b2", "#a9d1ea", "#ffffff", "#f3c39b", "#d55e00"]
)
_STRONG = 0.9


@style.styled
def correlation(names: Sequence[str], matrix: Float[np.ndarray, "n n"]) -> Figure:
    """A correlation matrix with its numbers; from 0.9 on they are bold and framed.

    Args:
        names: What the rows are called.
        matrix: Correlations [1].

    Returns:
        The figure.
    """
    count = len(names)
    figure, (axes,) = style.panels(1, 1, height=0.9 + 0.42 * count, width=3.2 + 0.95 * count)
    for row in range(count):
        for column in range(row + 1):
            value = float(matrix[row, column])
            strong = row != column and abs(value) >= _STRONG
            axes.add_patch(
                Rectangle(
                    (column + 0.04, row + 0.06),
                    0.92,
                    0.88,
                    facecolor=_SHADES(0.5 + 0.5 * value) if row != column else "#ececec",
                    edgecolor=style.BLACK if strong else "#d5d5d5",
                    lw=2.0 if strong else 0.6,
                )
            )
            axes.text(
                column + 0.5,
                row + 0.5,
                "1" if row == column else f"{value:+.2f}".replace("-", "−"),
                ha="center",
                va="center",
                fontsize=9,
                weight="bold" if strong else "normal",
                color="white" if row != column and abs(value) > 0.8 else style.BLACK,
            )
    axes.set(xlim=(0, count), ylim=(count, 0))
    axes.set_yticks(np.arange(count) + 0.5, names)
    axes.set_xticks(np.arange(count) + 0.5, [name.replace(" ", "\n", 2) for name in names])
    axes.tick_params(length=0)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return figure
