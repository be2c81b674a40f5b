"""Natural frequencies over the workspace by the model, and where the robot was knocked."""

from collections.abc import Sequence

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.page import style
from experiments.page.number_text import plain, rounded
from experiments.studies.findings.knocks import ModelCurve
from identification.knocks.frequency_map import FrequencyMap

_LABELLED = 8
"""Knocks of a panel that have their frequency beside them; more would cover each other."""
_FINEST = 1e-2
"""Error that a label's digits stand for at least [Hz]."""
_WORDS = (0.19, 0.08)
"""Width and height of a label, in widths of the frame [1]."""


@style.styled
def frequency_map(
    frequencies: FrequencyMap,
    curves: dict[float, ModelCurve],
    *,
    size: tuple[float, float],
    settings: Sequence[float],
) -> Figure:
    """The model's lowest natural frequency in the frame, the knocks on it in its colours.

    Args:
        frequencies: The knocks.
        curves: The model's frequencies by nominal pretension [N].
        size: Width and height of the frame [m].
        settings: Nominal pretensions to draw, a panel for each [N].

    Returns:
        The figure.
    """
    figure, grid = style.panels(len(settings), 1, height=3.2 * len(settings) + 0.7, width=5.0)
    shade = ScalarMappable(_scale(frequencies, curves), "viridis")
    for axes, setting in zip(grid, settings, strict=True):
        here = np.flatnonzero(frequencies.pretension == setting)
        _frame(axes, size)
        if setting in curves:
            _model(axes, curves[setting], size[0], shade)
        taken: list[tuple[float, float]] = []
        for row in here.tolist():
            _knock(axes, frequencies, row, shade)
            if here.size <= _LABELLED:
                _label(axes, frequencies, row, curves.get(setting), size=size, taken=taken)
        axes.set_title(f"nominal pretension {setting:g} N")
    bar = figure.colorbar(
        shade, ax=list(grid), orientation="horizontal", shrink=0.9, pad=0.02, aspect=30
    )
    bar.set_label("lowest natural frequency [Hz]")
    return figure


def _scale(frequencies: FrequencyMap, curves: dict[float, ModelCurve]) -> Normalize:
    values = [frequencies.frequency, *(curve.frequency[:, 0] for curve in curves.values())]
    low, high = float(min(map(np.min, values))), float(max(map(np.max, values)))
    margin = 0.02 * high + 0.5 * (high - low) * (high == low)
    return Normalize(low - margin, high + margin)


def _frame(axes: Axes, size: tuple[float, float]) -> None:
    width, height = (1e3 * length for length in size)
    axes.add_patch(Rectangle((0, 0), width, height, fill=False, lw=2.5, edgecolor=style.GREY))
    axes.grid(False)
    axes.set(
        xlim=(-0.03 * width, 1.03 * width),
        ylim=(-0.05 * height, 1.05 * height),
        aspect="equal",
        xlabel="xₑ [mm]",
        ylabel="yₑ [mm]",
    )


def _model(axes: Axes, curve: ModelCurve, width: float, shade: ScalarMappable) -> None:
    """Bands of the model's frequency; it doesn't change along the guides."""
    # The heights are equally spaced, and an image holds pixels about them.
    half = (curve.height[1] - curve.height[0]) / 2
    axes.imshow(
        curve.frequency[:, :1],
        norm=shade.norm,
        cmap=shade.cmap,
        origin="lower",
        extent=(
            0,
            1e3 * width,
            1e3 * (curve.height[0] - half),
            1e3 * (curve.height[-1] + half),
        ),
        aspect="equal",
        interpolation="nearest",
        zorder=0,
    )


def _knock(axes: Axes, frequencies: FrequencyMap, row: int, shade: ScalarMappable) -> None:
    noise = bool(frequencies.residuals_are_noise[row])
    axes.plot(
        1e3 * float(frequencies.x[row]),
        1e3 * float(frequencies.y[row]),
        "o" if noise else "s",
        ms=13,
        color=shade.to_rgba(float(frequencies.frequency[row])),
        mec="white",
        mew=2.0,
        zorder=4,
        path_effects=(patheffects.withStroke(linewidth=4, foreground=style.BLACK),),
    )


def _label(
    axes: Axes,
    frequencies: FrequencyMap,
    row: int,
    curve: ModelCurve | None,
    *,
    size: tuple[float, float],
    taken: list[tuple[float, float]],
) -> None:
    """A knock's frequency where no other label is, and how far the model is from it."""
    value, sigma = float(frequencies.frequency[row]), float(frequencies.frequency_sigma[row])
    x, y = float(frequencies.x[row]), float(frequencies.y[row])
    # Four digits at most here, all in the table: maps have many poses.
    lines = [f"{rounded(value, max(10 * sigma, _FINEST))} Hz"]
    if curve is not None:
        model = float(np.interp(y, curve.height, curve.frequency[:, 0]))
        sign = "−" if model < value else "+"
        lines.append(f"{sign}{plain(100 * abs(model / value - 1), 1)} %")
    place = _free_place((x, y), size, taken)
    taken.append(place)
    axes.annotate(
        "\n".join(lines),
        (1e3 * place[0], 1e3 * place[1]),
        ha="center",
        va="center",
        fontsize=10,
        linespacing=1.1,
        color=style.BLACK,
        bbox=style.WORDS_ON_COLOURS,
        zorder=5,
    )


def _free_place(
    at: tuple[float, float], size: tuple[float, float], taken: list[tuple[float, float]]
) -> tuple[float, float]:
    """Where a label covers the least: above its knock, below, right or left."""
    wide, high = (share * size[0] for share in _WORDS)
    around = ((0, 0.7 * high), (0, -0.7 * high), (0.65 * wide, 0), (-0.65 * wide, 0))
    places = [(at[0] + right, at[1] + up) for right, up in around]

    def covered(place: tuple[float, float]) -> float:
        outside = sum(
            max(half - where, where + half - length, 0.0)
            for where, half, length in zip(place, (wide / 2, high / 2), size, strict=True)
        )
        others = sum(
            max(wide - abs(place[0] - x), 0.0) * max(high - abs(place[1] - y), 0.0)
            for x, y in taken
        )
        return outside + others / wide

    return min(places, key=covered)


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
        1, len(settings), sharey=True, height=3.6, width=5.0 * len(settings)
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
        axes.yaxis.set_tick_params(labelleft=True)
        axes.set_ylabel("natural frequency [Hz]")
    style.figure_legend(figure, grid[0])
    return figure
