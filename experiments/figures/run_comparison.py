"""A run measured and simulated, one panel for each quantity."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.coordinates import CAMERA, ENCODERS, Coordinate
from experiments.style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    VERMILION,
    figure_legend,
    label,
    legend_above,
    new_figure,
    styled,
    thinned,
)
from identification.comparison import Comparison

_PANELS = ("x_e", "q_3", "y_e", "q_4", "delta_e")
_PER_CAMERA_SIGMA = 6.0  # times the noise: less than this is shown on an axis as wide


@styled
def run_comparison(comparison: Comparison) -> Figure:
    """Measurements of a run over its simulation: camera, encoders and commands.

    Args:
        comparison: The run.

    Returns:
        The figure; without a camera it has the encoders and the commands only.
    """
    seen = [name for name in _PANELS if _is_seen(comparison, name)]
    panels = len(seen) + 2 + (len(seen) % 2)
    rows = (panels + 1) // 2
    figure = new_figure(height=0.5 + 1.75 * rows)
    grid = np.atleast_2d(figure.subplots(rows, 2, sharex=True)).ravel()
    for axes, name in zip(grid, seen, strict=False):
        _camera_panel(axes, comparison, name)
    _encoder_panel(grid[len(seen)], comparison)
    _command_panel(grid[len(seen) + 1], comparison)
    for axes in grid[len(seen) + 2 :]:
        axes.set_axis_off()
    for axes in grid[max(len(seen), 0) :][:2]:
        axes.xaxis.set_tick_params(labelbottom=True)
    for axes in grid[-2:]:
        axes.set_xlabel(label("time", "s"))
    if seen:
        figure_legend(figure, grid[0])
    if comparison.held_out:
        figure.suptitle(
            "NOT FITTED: this run is predicted from the others",
            color=VERMILION,
            weight="bold",
            ha="left",
            x=0.01,
            fontsize=11,
        )
    return figure


def _is_seen(comparison: Comparison, name: str) -> bool:
    return bool(np.any(np.isfinite(_column(comparison.measured, name))))


def _column(positions: Float[np.ndarray, "rows 5"], name: str) -> Float[np.ndarray, " rows"]:
    index, coordinate = next((i, c) for i, c in enumerate(CAMERA) if c.name == name)
    return coordinate.factor * positions[:, index]


def _coordinate(name: str) -> Coordinate:
    return next(coordinate for coordinate in CAMERA if coordinate.name == name)


def _camera_panel(axes: Axes, comparison: Comparison, name: str) -> None:
    coordinate = _coordinate(name)
    measured = _column(comparison.measured, name)
    if comparison.path.size:
        path = _column(comparison.path, name)
        axes.plot(*thinned(comparison.time, path), color=VERMILION, lw=1.3, label="simulated")
    axes.plot(
        comparison.frame_time,
        measured,
        ls="",
        marker="o",
        ms=2.6,
        color=BLUE,
        alpha=0.75,
        label="camera",
        zorder=3,
    )
    axes.set_ylabel(label(coordinate.symbol, coordinate.unit))
    axes.set_title(coordinate.meaning, fontsize=9, weight="normal", color=GREY)
    channel = next(c for c in comparison.channels if c.name == name)
    _widen(axes, _PER_CAMERA_SIGMA * channel.sigma * coordinate.factor)


def _widen(axes: Axes, least: float) -> None:
    """An axis that isn't filled by noise alone."""
    low, high = axes.get_ylim()
    if high - low < 2 * least:
        middle = (low + high) / 2
        axes.set_ylim(middle - least, middle + least)


def _encoder_panel(axes: Axes, comparison: Comparison) -> None:
    shades = ((BLUE, "-"), (ORANGE, "-"))
    for index, (coordinate, (color, style)) in enumerate(zip(ENCODERS, shades, strict=True)):
        measured = coordinate.factor * comparison.measured_angle[:, index]
        simulated = coordinate.factor * comparison.simulated_angle[:, index]
        axes.plot(
            *thinned(comparison.time, measured),
            color=color,
            ls=style,
            lw=3.5,
            alpha=0.55,
            label=f"{coordinate.symbol} encoder",
        )
        axes.plot(
            *thinned(comparison.time, simulated),
            color=BLACK,
            ls=(0, (4, 2)) if index else (0, (1, 1.5)),
            lw=1.0,
            label=f"{coordinate.symbol} simulated",
        )
    axes.set_ylabel(label("α₁, α₂", "°"))
    legend_above(axes)


def _command_panel(axes: Axes, comparison: Comparison) -> None:
    for index, (color, width) in enumerate(((BLUE, 2.6), (ORANGE, 1.2))):
        time, voltage = thinned(comparison.time, comparison.voltage[:, index])
        axes.step(
            time, voltage, where="post", color=color, lw=width, label=f"V{'₁₂'[index]} command"
        )
    axes.set_ylabel(label("command", "V"))
    _widen(axes, 0.5)
    legend_above(axes)
