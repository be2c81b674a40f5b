"""Equations (24) and (25): a drive's step response and the loop's Bode diagram."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.loop.numbers import (
    CROSSOVER,
    STEP,
    Design,
    StepResponse,
    open_loop,
)


@style.styled
def draw_step_response(response: StepResponse) -> Figure:
    """Speed of a bare drive after a step.

    Args:
        response: The response.

    Returns:
        The figure.
    """
    figure, (axes,) = style.panels(1, 1, height=2.8, width=5.0)
    axes.plot(
        response.time, response.speed, "o", ms=3, color=style.BLUE, label="encoder, 10 ms"
    )
    axes.plot(response.time, response.fitted, color=style.VERMILION, label="fitted (24)")
    axes.set(xlabel="time [s]", ylabel=f"speed after {STEP:g} V [°/s]")
    style.legend_above(axes)
    return figure


@style.styled
def draw_bode(designs: dict[str, Design]) -> Figure:
    """Open loops of the drive with several controllers.

    Args:
        designs: Controllers with their margins, by name.

    Returns:
        The figure.
    """
    figure, (gain, phase) = style.panels(1, 2, height=3.2)
    omega = np.geomspace(5, 500, 300)
    for (name, design), colour in zip(
        designs.items(), (style.BLUE, style.VERMILION), strict=True
    ):
        loop = open_loop(design.controller, omega)
        gain.loglog(omega, np.abs(loop), color=colour, label=name)
        phase.semilogx(omega, np.rad2deg(np.unwrap(np.angle(loop))), color=colour)
    gain.axhline(1, color=style.BLACK, lw=0.8)
    for axes in (gain, phase):
        axes.axvline(CROSSOVER, color=style.GREY, ls="--", lw=1)
        axes.set_xlabel("angular frequency [rad/s]")
    phase.axhline(-120, color=style.GREY, ls="--", lw=1)
    for axis in (gain.xaxis, gain.yaxis, phase.xaxis):
        style.decades(axis)
    gain.set_ylabel("|R G| [1]")
    phase.set_ylabel("phase [°]")
    style.legend_above(gain)
    return figure
