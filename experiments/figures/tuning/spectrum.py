"""A measured spectrum, what shapers leave of it, and vibration against duration."""

import itertools
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from experiments.page import style
from experiments.studies.findings.responses import NamedShaper
from tuning.shapers.spectrum import THRESHOLD, Spectrum
from tuning.shapers.spectrum_design import SpectrumDesign

_POINTS = 600
_STYLES = (
    (style.VERMILION, "-"),
    (style.GREEN, "--"),
    (style.PURPLE, "-."),
    (style.ORANGE, ":"),
)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_LEAST = 1e-3
"""Vibration left below which a mark is drawn at the axis's lower end [%]."""


@style.styled
def shaped_spectrum(spectrum: Spectrum, shapers: Sequence[NamedShaper]) -> Figure:
    """The spectrum before and after shaping, the shapers' residual vibration, impulses.

    Args:
        spectrum: The spectrum.
        shapers: Up to four shapers, each with the damping ratio to draw it at.

    Returns:
        The figure.
    """
    figure = style.new_figure(height=6.4, width=8.6)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.4, 1.0))
    power, left = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    impulses = figure.add_subplot(grid[:, 1])
    power.sharex(left)
    for number, measured in enumerate(spectrum.by_sensor):
        power.fill_between(spectrum.frequency, measured, color=style.SKY, alpha=0.35, lw=0)
        named = {} if number else {"label": "measured"}
        power.plot(spectrum.frequency, measured, color=style.BLUE, lw=1.6, **named)
    power.axhline(THRESHOLD, color=style.GREY, ls=(0, (2, 2)), lw=1)
    fine = np.linspace(float(spectrum.frequency[0]), float(spectrum.frequency[-1]), _POINTS)
    for (color, dashes), named in zip(_STYLES, shapers, strict=False):
        curve = 100 * named.residual(fine)
        left.plot(fine, curve, color=color, ls=dashes, label=named.name)
        after = spectrum.by_sensor * named.residual(spectrum.frequency)
        power.plot(
            spectrum.frequency, after.max(axis=0), color=color, ls=dashes, label=named.name
        )
        times = 1e3 * np.asarray(named.shaper.times)
        amplitudes = np.asarray(named.shaper.amplitudes)
        impulses.vlines(times, 0, amplitudes, color=color, lw=2.2).set_linestyle(dashes)
        impulses.plot(times, amplitudes, "o", color=color, ms=5)
    power.set(ylabel="spectrum over its peak [1]", ylim=(0, 1.05))
    left.set(
        ylim=(0, 105),
        ylabel="residual vibration [%]",
        xlabel="frequency [Hz]",
        xlim=(0, float(spectrum.frequency[-1])),
    )
    impulses.set(ylim=(0, None), xlabel="time [ms]", ylabel="impulse amplitude [1]")
    figure.align_ylabels([power, left])
    style.figure_legend(figure, power)
    return figure


def front_curve(
    design: SpectrumDesign,
) -> tuple[Float[np.ndarray, " designs"], Float[np.ndarray, " designs"]]:
    """Duration [ms] and vibration left [%] of every optimised design, in order.

    Args:
        design: The design.

    Returns:
        Durations and vibrations.
    """
    instead = itertools.chain.from_iterable(
        (one.same_duration, one.same_vibration) for one in design.compared
    )
    every = [*design.front, *instead, design.recommended]
    points = sorted({(1e3 * float(d.shaper.duration), 100 * d.residual) for d in every})
    durations, vibrations = np.array(points).T
    return durations, vibrations


@style.styled
def duration_against_vibration(design: SpectrumDesign) -> Figure:
    """The front of optimised shapers, and the catalogue's above it.

    Args:
        design: The design.

    Returns:
        The figure.
    """
    figure, (axes,) = style.panels(1, 1, height=4.2, width=5.0)
    durations, vibrations = front_curve(design)
    axes.plot(
        durations,
        np.maximum(vibrations, _LEAST),
        color=style.BLUE,
        lw=1.8,
        marker=".",
        ms=6,
        label="optimised",
    )
    for marker, one in zip(itertools.cycle(_MARKERS), design.compared, strict=False):
        axes.plot(
            1e3 * float(one.fit.shaper.duration),
            max(100 * one.fit.residual, _LEAST),
            marker=marker,
            color=style.VERMILION,
            ls="none",
            ms=7,
            label=one.fit.entry.name,
        )
    axes.plot(
        1e3 * float(design.recommended.shaper.duration),
        max(100 * design.recommended.residual, _LEAST),
        marker="*",
        color=style.GREEN,
        ls="none",
        ms=15,
        label="recommended",
    )
    axes.set(
        yscale="log",
        ylim=(0.7 * _LEAST, 100),
        xlabel="duration of the shaper [ms]",
        ylabel="vibration left [%]",
    )
    style.decades(axes.yaxis)
    style.figure_legend(figure, axes, columns=5)
    return figure
