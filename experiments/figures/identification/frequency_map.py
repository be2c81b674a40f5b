"""Natural frequencies where the robot was knocked, measured and by the model."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.page import style
from experiments.page.number_text import plain, rounded
from experiments.studies.findings.knocks import ModelCurve
from identification.knocks.frequency_map import FrequencyMap


@style.styled
def frequency_map(
    frequencies: FrequencyMap, *, size: tuple[float, float], settings: Sequence[float]
) -> Figure:
    """Natural frequencies in the frame, one panel for each pretension setting.

    Args:
        frequencies: The map.
        size: Width and height of the frame [m].
        settings: Nominal pretensions to draw [N].

    Returns:
        The figure.
    """
    figure, grid = style.panels(len(settings), 1, height=3.9 * len(settings) + 0.2, width=9.0)
    low, high = float(frequencies.frequency.min()), float(frequencies.frequency.max())
    margin = 0.02 * high + 0.5 * (high - low) * (high == low)
    shade = ScalarMappable(Normalize(low - margin, high + margin), "viridis")
    for axes, setting in zip(grid, settings, strict=True):
        here = frequencies.pretension == setting
        _frame(axes, size)
        for row in np.flatnonzero(here).tolist():
            _knock(axes, frequencies, row, shade)
        axes.set_title(f"nominal pretension {setting:g} N")
    bar = figure.colorbar(shade, ax=list(grid), shrink=0.8, pad=0.01)
    bar.set_label("natural frequency [Hz]")
    return figure


def _frame(axes: Axes, size: tuple[float, float]) -> None:
    width, height = (1e3 * length for length in size)
    axes.add_patch(Rectangle((0, 0), width, height, fill=False, lw=2.5, edgecolor=style.GREY))
    axes.set(
        xlim=(-0.03 * width, 1.03 * width),
        ylim=(-0.05 * height, 1.05 * height),
        aspect="equal",
        xlabel="xₑ [mm]",
        ylabel="yₑ [mm]",
    )


def _knock(axes: Axes, frequencies: FrequencyMap, row: int, shade: ScalarMappable) -> None:
    value, sigma = float(frequencies.frequency[row]), float(frequencies.frequency_sigma[row])
    x, y = 1e3 * float(frequencies.x[row]), 1e3 * float(frequencies.y[row])
    noise = bool(frequencies.residuals_are_noise[row])
    axes.plot(
        x,
        y,
        "o" if noise else "s",
        ms=13,
        color=shade.to_rgba(value),
        mec=style.BLACK,
        mew=1.0 if noise else 2.0,
    )
    # One digit of the error here, both in the table: maps have many poses.
    text = f"{rounded(value, 10 * sigma)} Hz\n± {plain(sigma, 1)}"
    axes.annotate(
        text if noise else f"{text}, sliding",
        (x, y),
        xytext=(0, 11),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=9,
    )


@style.styled
def frequency_over_height(frequencies: FrequencyMap, curves: dict[float, ModelCurve]) -> Figure:
    """Measured natural frequencies beside the model's, both carriages held.

    Args:
        frequencies: The map.
        curves: The model's frequencies by nominal pretension [N].

    Returns:
        The figure, one panel for each pretension that was measured.
    """
    settings = sorted(set(frequencies.pretension.tolist()))
    figure, grid = style.panels(
        1, len(settings), sharey=True, height=3.6, width=max(6.5, 4.2 * len(settings))
    )
    for axes, setting in zip(grid, settings, strict=True):
        if setting in curves:
            curve = curves[setting]
            for mode, dashes in enumerate(("-", "--")):
                axes.plot(
                    1e3 * curve.height,
                    curve.frequency[:, mode],
                    color=style.VERMILION,
                    ls=dashes,
                    label=f"model, mode {mode + 1}",
                )
        here = frequencies.pretension == setting
        axes.errorbar(
            1e3 * frequencies.y[here],
            frequencies.frequency[here],
            yerr=2 * frequencies.frequency_sigma[here],
            fmt="o",
            ms=6,
            color=style.BLUE,
            capsize=4,
            label="measured, ±2 σ",
            zorder=3,
        )
        axes.set(xlabel="yₑ [mm]", title=f"nominal pretension {setting:g} N", ylim=(0, None))
    grid[0].set_ylabel("natural frequency [Hz]")
    style.figure_legend(figure, grid[0])
    return figure
