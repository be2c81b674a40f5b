"""A run measured and simulated, one panel for each quantity."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.page import style
from experiments.page.coordinates import CAMERA, COORDINATES, ENCODERS
from identification.fit.comparison import Comparison

_PANELS = ("x_e", "q_3", "y_e", "q_4", "delta_e")
_LEAST_NOISE = 6.0  # standard deviations to either side: noise alone doesn't fill an axis
_DOTS = {"marker": "o", "ms": 3.4, "mew": 0.0, "alpha": 0.85}
_LEAST_VOLTAGE = 0.5  # V to either side


@style.styled
def run_comparison(comparison: Comparison) -> Figure:
    """Measurements of a run under its simulation: camera, commands and encoders.

    Args:
        comparison: The run.

    Returns:
        The figure; without a camera it has the commands and the encoders only.
    """
    seen = [name for name in _PANELS if _is_seen(comparison, name)]
    count = len(seen) + 1 + len(ENCODERS)
    columns = 2
    rows = -(-count // columns)
    figure, grid = style.panels(rows, columns, sharex=True, height=0.6 + 2.0 * rows)
    for axes, name in zip(grid, seen, strict=False):
        _camera_panel(axes, comparison, name)
    _command_panel(grid[len(seen)], comparison)
    for index, axes in enumerate(grid[len(seen) + 1 :][: len(ENCODERS)]):
        _encoder_panel(axes, comparison, index)
    for axes in grid[count:]:
        axes.set_axis_off()
    # On a phone each panel stands by itself.
    for axes in grid[:count]:
        axes.xaxis.set_tick_params(labelbottom=True)
        axes.set_xlabel("time [s]")
    _legend(figure, seen)
    return figure


def _legend(figure: Figure, seen: list[str]) -> None:
    handles = [
        Line2D([], [], color=style.SKY, lw=4, label="encoder"),
        Line2D([], [], color=style.VERMILION, lw=1.3, label="simulated"),
    ]
    if seen:
        handles.insert(0, Line2D([], [], ls="", color=style.BLUE, **_DOTS, label="camera"))
    figure.legend(handles=handles, loc="outside upper right", ncols=3)


def _is_seen(comparison: Comparison, name: str) -> bool:
    return bool(np.any(np.isfinite(_column(comparison.measured, name))))


def _column(positions: Float[np.ndarray, "rows 5"], name: str) -> Float[np.ndarray, " rows"]:
    index, coordinate = next((i, c) for i, c in enumerate(CAMERA) if c.name == name)
    return coordinate.factor * positions[:, index]


def _camera_panel(axes: Axes, comparison: Comparison, name: str) -> None:
    coordinate = COORDINATES[name]
    measured = _column(comparison.measured, name)
    axes.plot(comparison.frame_time, measured, ls="", color=style.BLUE, **_DOTS)
    if comparison.path.size:
        path = _column(comparison.path, name)
        axes.plot(*style.thinned(comparison.time, path), color=style.VERMILION, lw=1.1)
    channel = next(c for c in comparison.channels if c.name == name)
    _name(axes, coordinate.meaning, f"{coordinate.symbol} [{coordinate.unit}]")
    _widen(axes, _LEAST_NOISE * channel.sigma * coordinate.factor)


def _encoder_panel(axes: Axes, comparison: Comparison, index: int) -> None:
    coordinate = ENCODERS[index]
    measured = coordinate.factor * comparison.measured_angle[:, index]
    simulated = coordinate.factor * comparison.simulated_angle[:, index]
    axes.plot(*style.thinned(comparison.time, measured), color=style.SKY, lw=4)
    axes.plot(*style.thinned(comparison.time, simulated), color=style.VERMILION, lw=1.1)
    _name(axes, coordinate.meaning, f"{coordinate.symbol} [{coordinate.unit}]")


def _command_panel(axes: Axes, comparison: Comparison) -> None:
    for index, (color, width) in enumerate(((style.BLUE, 2.6), (style.ORANGE, 1.2))):
        time, voltage = style.thinned(comparison.time, comparison.voltage[:, index])
        axes.step(time, voltage, where="post", color=color, lw=width, label=f"V{'₁₂'[index]}")
    _name(axes, "commands", "V₁, V₂ [V]")
    _widen(axes, _LEAST_VOLTAGE)
    style.legend_above(axes)


def _name(axes: Axes, meaning: str, name: str) -> None:
    axes.set_title(meaning, weight="normal", color=style.GREY)
    axes.set_ylabel(name)


def _widen(axes: Axes, least: float) -> None:
    """An axis that isn't filled by noise alone."""
    low, high = axes.get_ylim()
    if high - low < 2 * least:
        middle = (low + high) / 2
        axes.set_ylim(middle - least, middle + least)
