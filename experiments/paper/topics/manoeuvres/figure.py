"""Figures 16 to 20: tracking of the manoeuvres of Table 3."""

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.manoeuvres.numbers import Tracked
from scdpr_jax.robot.state import HEIGHT, TILT, X, pose


@style.styled
def draw_tracking(run: Tracked) -> Figure:
    """Both coordinates of a manoeuvre beside their references, Figures 16 and 17.

    Args:
        run: The run.

    Returns:
        The figure.
    """
    figure, panels = style.panels(1, 2, height=3.0)
    for axes, column, part in zip(panels, (X, HEIGHT), (0, 1), strict=True):
        axes.plot(
            *style.thinned(run.time, 1e3 * run.position[:, column]),
            color=style.BLUE,
            label="end-effector",
        )
        axes.plot(
            *style.thinned(run.time, 1e3 * run.reference[:, part]),
            color=style.BLACK,
            ls="--",
            lw=1.0,
            label="reference",
        )
        axes.set(ylabel=f"{('xₑ', 'yₑ')[part]} [mm]", xlabel="time [s]")
        style.legend_above(axes)
        middle = 1e3 * np.mean(run.reference[:, part])
        low, high = axes.get_ylim()
        if high - low < 20:
            axes.set_ylim(middle - 10, middle + 10)
    return figure


@style.styled
def draw_errors(runs: dict[str, tuple[Tracked, float]]) -> Figure:
    """Errors over time, Eq. (26), with the reported largest ones, Figure 18.

    Args:
        runs: Runs by name, each with the reported largest error [m].

    Returns:
        The figure.
    """
    figure, panels = style.panels(1, len(runs), height=3.0)
    for axes, (name, (run, reported)) in zip(panels, runs.items(), strict=True):
        axes.plot(*style.thinned(run.time, 1e3 * run.error), color=style.BLUE)
        axes.axhline(1e3 * reported, color=style.GREY, ls="--", lw=1.2)
        axes.annotate(
            f"reported: about {1e3 * reported:.0f} mm",
            (run.time[-1], 1e3 * reported),
            xytext=(0, 3),
            textcoords="offset points",
            ha="right",
            color=style.GREY,
        )
        axes.set(
            title=name,
            ylim=(0, 1.25e3 * max(reported, run.error.max())),
            xlabel="time [s]",
            ylabel="εₑ [mm]",
        )
    return figure


@style.styled
def draw_diagonal(run: Tracked) -> Figure:
    """Path and rotation of the diagonal manoeuvre, Figure 19.

    Args:
        run: The run.

    Returns:
        The figure.
    """
    figure, (path, tilt) = style.panels(1, 2, height=3.2)
    path.plot(*(1e3 * pose(run.position)[::10].T), color=style.BLUE, label="end-effector")
    path.plot(
        *(1e3 * run.reference[::10].T), color=style.BLACK, ls="--", lw=1.0, label="reference"
    )
    path.set(xlabel="xₑ [mm]", ylabel="yₑ [mm]")
    style.legend_above(path)
    tilt.plot(*style.thinned(run.time, np.rad2deg(run.position[:, TILT])), color=style.BLUE)
    for sign in (-1, 1):
        tilt.axhline(sign * 3.2, color=style.GREY, ls="--", lw=1.0)
    tilt.set(title="rotation, and the reported 3.2°", xlabel="time [s]", ylabel="δₑ [°]")
    return figure


@style.styled
def draw_joints(run: Tracked, *, limit: float) -> Figure:
    """Joint angles and control signals of a manoeuvre, Figure 20.

    Args:
        run: The run.
        limit: Largest command of either sign [V].

    Returns:
        The figure.
    """
    figure, (joints, command) = style.panels(1, 2, height=3.2)
    for motor, colour in enumerate((style.BLUE, style.VERMILION)):
        name = f"α{'₁₂'[motor]}"
        joints.plot(*style.thinned(run.time, run.angle[:, motor]), color=colour, label=name)
        joints.plot(
            *style.thinned(run.time, run.angle_reference[:, motor]),
            color=style.BLACK,
            ls="--",
            lw=0.9,
            label="references" if motor == 0 else None,
        )
        command.plot(
            *style.thinned(run.time[:-1], run.voltage[:, motor]),
            color=colour,
            label=f"V{'₁₂'[motor]}",
        )
    for sign in (-1, 1):
        command.axhline(sign * limit, color=style.GREY, ls="--", lw=1.0)
    joints.set_ylabel("angle [rad]")
    command.set_ylabel("command [V]")
    for axes in (joints, command):
        axes.set_xlabel("time [s]")
        style.legend_above(axes)
    return figure
