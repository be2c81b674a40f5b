"""Figures 16 to 20: tracking of the manoeuvres of Table 3."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILION,
    label,
    legend_above,
    new_figure,
    styled,
    thinned,
)
from experiments.paper.topics.manoeuvres.numbers import Tracked
from scdpr_jax.robot.state import HEIGHT, TILT, X, pose


@styled
def draw_tracking(run: Tracked) -> Figure:
    """Both coordinates of a manoeuvre beside their references, Figures 16 and 17.

    Args:
        run: The run.

    Returns:
        The figure.
    """
    figure = new_figure(height=3.0)
    for axes, column, part in zip(figure.subplots(1, 2), (X, HEIGHT), (0, 1), strict=True):
        axes.plot(
            *thinned(run.time, 1e3 * run.position[:, column]), color=BLUE, label="end-effector"
        )
        axes.plot(
            *thinned(run.time, 1e3 * run.reference[:, part]),
            color=BLACK,
            ls="--",
            lw=1.0,
            label="reference",
        )
        axes.set_ylabel(label(("xₑ", "yₑ")[part], "mm"))
        axes.set_xlabel(label("time", "s"))
        legend_above(axes)
        middle = 1e3 * np.mean(run.reference[:, part])
        low, high = axes.get_ylim()
        if high - low < 20:
            axes.set_ylim(middle - 10, middle + 10)
    return figure


@styled
def draw_errors(runs: dict[str, tuple[Tracked, float]]) -> Figure:
    """Errors over time, Eq. (26), with the reported largest ones, Figure 18.

    Args:
        runs: Runs by name, each with the reported largest error [m].

    Returns:
        The figure.
    """
    figure = new_figure(height=3.0)
    panels = np.atleast_1d(figure.subplots(1, len(runs)))
    for axes, (name, (run, reported)) in zip(panels, runs.items(), strict=True):
        axes.plot(*thinned(run.time, 1e3 * run.error), color=BLUE)
        axes.axhline(1e3 * reported, color=GREY, ls="--", lw=1.2)
        axes.annotate(
            f"reported: about {1e3 * reported:.0f} mm",
            (run.time[-1], 1e3 * reported),
            xytext=(0, 3),
            textcoords="offset points",
            ha="right",
            color=GREY,
        )
        axes.set_title(name)
        axes.set_ylim(0, 1.25e3 * max(reported, run.error.max()))
        axes.set_xlabel(label("time", "s"))
        axes.set_ylabel(label("εₑ", "mm"))
    return figure


@styled
def draw_diagonal(run: Tracked) -> Figure:
    """Path and rotation of the diagonal manoeuvre, Figure 19.

    Args:
        run: The run.

    Returns:
        The figure.
    """
    figure = new_figure(height=3.2)
    path, tilt = figure.subplots(1, 2)
    path.plot(*(1e3 * pose(run.position)[::10].T), color=BLUE, label="end-effector")
    path.plot(*(1e3 * run.reference[::10].T), color=BLACK, ls="--", lw=1.0, label="reference")
    path.set_xlabel(label("xₑ", "mm"))
    path.set_ylabel(label("yₑ", "mm"))
    legend_above(path)
    tilt.plot(*thinned(run.time, np.rad2deg(run.position[:, TILT])), color=BLUE)
    for sign in (-1, 1):
        tilt.axhline(sign * 3.2, color=GREY, ls="--", lw=1.0)
    tilt.set_title("rotation, and the reported 3.2°")
    tilt.set_xlabel(label("time", "s"))
    tilt.set_ylabel(label("δₑ", "°"))
    return figure


@styled
def draw_joints(run: Tracked, *, limit: float) -> Figure:
    """Joint angles and control signals of a manoeuvre, Figure 20.

    Args:
        run: The run.
        limit: Largest command of either sign [V].

    Returns:
        The figure.
    """
    figure = new_figure(height=3.2)
    joints, command = figure.subplots(1, 2)
    for motor, colour in enumerate((BLUE, VERMILION)):
        name = f"α{'₁₂'[motor]}"
        joints.plot(*thinned(run.time, run.angle[:, motor]), color=colour, label=name)
        joints.plot(
            *thinned(run.time, run.angle_reference[:, motor]),
            color=BLACK,
            ls="--",
            lw=0.9,
            label="references" if motor == 0 else None,
        )
        command.plot(
            *thinned(run.time[:-1], run.voltage[:, motor]),
            color=colour,
            label=f"V{'₁₂'[motor]}",
        )
    for sign in (-1, 1):
        command.axhline(sign * limit, color=GREY, ls="--", lw=1.0)
    joints.set_ylabel(label("angle", "rad"))
    command.set_ylabel(label("command", "V"))
    for axes in (joints, command):
        axes.set_xlabel(label("time", "s"))
        legend_above(axes)
    return figure
