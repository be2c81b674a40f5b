"""What a simulation leaves of the measurements, in units of the sensors' noise."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.coordinates import CAMERA, ENCODERS
from identification.fit.comparison import Comparison

_BINS = 150
_LEAST = 4.0  # standard deviations: noise alone fills the axis up to here


def residuals_in_sigma(
    comparison: Comparison,
) -> dict[str, tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]]:
    """Measurement minus simulation over the sensor's standard deviation.

    Args:
        comparison: The run.

    Returns:
        Time [s] and residual [1] of each channel that was measured, by its name.
    """
    angle = comparison.measured_angle - comparison.simulated_angle
    frame = comparison.measured - comparison.simulated
    series = {}
    for channel in comparison.channels:
        names = [coordinate.name for coordinate in ENCODERS]
        if channel.name in names:
            time, values = comparison.time, angle[:, names.index(channel.name)]
        else:
            column = [coordinate.name for coordinate in CAMERA].index(channel.name)
            time, values = comparison.frame_time, frame[:, column]
        seen = np.isfinite(values)
        series[channel.name] = (time[seen], values[seen] / channel.sigma)
    return series


@style.styled
def residuals(comparison: Comparison) -> Figure:
    """Residuals of a run over time, the band of two standard deviations shaded.

    Args:
        comparison: The run.

    Returns:
        The figure: camera and encoders, without a camera the encoders only.
    """
    series = residuals_in_sigma(comparison)
    camera = [coordinate for coordinate in CAMERA if coordinate.name in series]
    columns = 2 if camera else 1
    figure, grid = style.panels(1, columns, sharex=True, height=2.6, width=5.0 * columns)
    if camera:
        for coordinate in camera:
            grid[0].plot(
                *series[coordinate.name],
                ls="",
                marker=coordinate.marker,
                ms=3.2,
                mew=0,
                alpha=0.8,
                color=coordinate.color,
                label=coordinate.symbol,
            )
        _finish(grid[0], "camera residual")
    for coordinate, color in zip(ENCODERS, (style.BLUE, style.ORANGE), strict=True):
        if coordinate.name in series:
            _band(grid[-1], *series[coordinate.name], color=color, name=coordinate.symbol)
    _finish(grid[-1], "encoder residual")
    return figure


def _band(
    axes: Axes,
    time: Float[np.ndarray, " n"],
    values: Float[np.ndarray, " n"],
    *,
    color: str,
    name: str,
) -> None:
    """A dense series as the band of its extremes and the line of its means."""
    bins = np.array_split(np.arange(len(time)), min(_BINS, len(time)))
    low, high, mean, at = (
        np.array([take(part[index]) for index in bins])
        for take, part in (
            (np.min, values),
            (np.max, values),
            (np.mean, values),
            (np.mean, time),
        )
    )
    axes.fill_between(at, low, high, color=color, alpha=0.3, lw=0)
    axes.plot(at, mean, color=color, lw=1.3, label=f"{name} mean and extremes")


def _finish(axes: Axes, name: str) -> None:
    axes.axhspan(-2, 2, color="#ececec", zorder=0, label="±2 σ")
    axes.axhline(0, color=style.GREY, lw=0.6)
    axes.set(xlabel="time [s]", ylabel=f"{name} [σ]")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -_LEAST), max(high, _LEAST))
    style.legend_above(axes, columns=6)
