"""A planned leg beside the plain one: the way, the arrival, the commands, other robots."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.figures.tuning.tracking import draw_commands, name_commands
from experiments.page import style
from experiments.studies.legs.planned_leg import SIDES, Compared
from scdpr_jax.legs.leg import Leg
from scdpr_jax.legs.measures import SETTLED

_BEFORE = 0.4
"""Time before the leg's end that its arrival is shown from [s]."""
_STYLES = ((style.VERMILION, 1.3), (style.BLUE, 1.7))
_LEAST = 1e-3
"""Vibration below which it is drawn as this [mm]: a count of the encoders moves more."""


@style.styled
def leg(compared: Compared, *, leg_time: float, voltage_limit: float) -> Figure:
    """A leg before and after planning.

    Args:
        compared: Its runs.
        leg_time: Time of the leg [s].
        voltage_limit: Largest command of either sign [V].

    Returns:
        The figure.
    """
    figure, (way, arrival, command, others) = style.panels(2, 2, height=7.2)
    fitted = compared.planned[0]
    _, target = _along(fitted)
    way.plot(
        *style.thinned(fitted.time, 1e3 * target),
        color=style.BLACK,
        lw=1.0,
        ls="--",
        zorder=3,
        label="reference of the plan",
    )
    sides = zip(SIDES, (compared.plain, compared.planned), _STYLES, strict=True)
    for name, runs, (color, width) in sides:
        first: Leg = runs[0]
        done, _ = _along(first)
        way.plot(*style.thinned(first.time, 1e3 * done), color=color, lw=width, label=name)
        late = first.time >= leg_time - _BEFORE
        away = 1e3 * (first.pose[late, 0] - first.reference[-1, 0])
        arrival.plot(*style.thinned(first.time[late], away), color=color, lw=width)
        draw_commands(command, first.time, first.voltage, color=color)
        left = [max(1e3 * run.measures.residual_vibration, _LEAST) for run in runs]
        others.plot(left, range(len(runs)), "o", color=color)
    _bounds(arrival, leg_time, compared)
    name_commands(command, voltage_limit=voltage_limit)
    for place, name in enumerate(compared.names):
        # Above its dots, within the panel: a column of names would take half of a phone.
        others.annotate(
            name,
            (0.0, place - 0.38),
            xycoords=("axes fraction", "data"),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
        )
    others.set_yticks([])
    others.set_ylim(len(compared.names) - 0.6, -0.8)
    others.grid(False, axis="y")
    others.set_xscale("log")
    style.decades(others.xaxis)
    others.set_axisbelow(True)
    way.set(title="on the way", ylabel="distance covered [mm]")
    arrival.set(
        title=f"on arrival, and the band of ±{1e3 * SETTLED:g} mm",
        ylabel="xₑ from the target [mm]",
    )
    for axes in (way, arrival):
        axes.set_xlabel("time [s]")
    others.set(
        title="on robots as they might be", xlabel="vibration after the leg, peak to peak [mm]"
    )
    style.figure_legend(figure, way, columns=3)
    return figure


def _along(run: Leg) -> tuple[np.ndarray, np.ndarray]:
    """Ways of the end-effector and of its reference along the leg [m]."""
    start, end = run.reference[0], run.reference[-1]
    direction = (end - start) / np.hypot(*(end - start))
    return (run.pose - start) @ direction, (run.reference - start) @ direction


def _bounds(arrival: Axes, leg_time: float, compared: Compared) -> None:
    """The band in which a leg has settled, and the moment at which its reference ends."""
    band = 1e3 * SETTLED
    arrival.axhspan(-band, band, color=style.GREY, alpha=0.18, lw=0)
    arrival.axvline(leg_time, color=style.GREY, ls=":", lw=1)
    # On its way the end-effector is far off: what is of interest happens at the end.
    runs = (compared.plain[0], compared.planned[0])
    after = [
        1e3 * np.abs(run.pose[run.time >= leg_time, 0] - run.reference[-1, 0]).max()
        for run in runs
    ]
    reach = 1.2 * max(band, *after)
    arrival.set_ylim(-reach, reach)
