"""The run that would tell more: what it is worth beside the others, and what it does."""

from collections.abc import Sequence

import jax
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import plain
from experiments.studies.next_run import Aim
from identification.next_run.excitation import STEP
from identification.next_run.expected_information import MARGIN, Rig, motion
from identification.next_run.next_experiment import Candidate, stacked
from scdpr_jax.robot.quantities import value


@style.styled
def next_run_figure(rig: Rig, aim: Aim, candidates: Sequence[Candidate]) -> Figure:
    """Every candidate's worth a second, and the best one's voltages and path.

    Args:
        rig: What is known of the rig.
        aim: What the run is for.
        candidates: The candidates, the best one first.

    Returns:
        The figure.
    """
    figure = style.new_figure(height=1.8 + 0.32 * max(len(candidates), 9))
    worth, right = figure.subfigures(1, 2, width_ratios=(1.05, 1.0))
    _worth(worth.subplots(), aim, candidates)
    volts, path = right.subplots(2, 1, sharex=True)
    run = candidates[0].excitation
    time = STEP * np.arange(len(run.voltage) + 1)
    limit = float(value(rig.robot, "voltage_limit"))
    for drive, colour in enumerate((style.BLUE, style.VERMILION)):
        held = np.append(run.voltage[:, drive], 0.0)
        volts.step(time, held, where="post", color=colour, label=f"drive {drive + 1}")
    _limits(volts, (-limit, limit), "limit")
    volts.set(ylabel="voltage [V]", title=run.name)
    style.legend_above(volts)
    states = motion(rig, jax.tree.map(lambda leaf: leaf[0], stacked([run], len(run.voltage))))
    place, frame = np.asarray(states.position), rig.robot.frame
    path.plot(time, place[:, 0], color=style.BLUE, label="x")
    path.plot(time, place[:, 4], color=style.ORANGE, label="y")
    _limits(path, (MARGIN, float(frame.width) - MARGIN), "limit of x")
    path.set(ylabel="end-effector [m]", xlabel="time [s]")
    style.legend_above(path)
    return figure


def _worth(axes: Axes, aim: Aim, candidates: Sequence[Candidate]) -> None:
    rates = [one.rate for one in candidates]
    colours = [style.BLUE if one.excitation.designed else style.GREY for one in candidates]
    places = range(len(candidates))
    axes.barh(places, rates, color=colours, height=0.62)
    for place, one in zip(places, candidates, strict=True):
        axes.annotate(
            f"÷ {plain(float(np.exp(one.gain)), 3)} in {one.excitation.duration:.1f} s",
            (max(one.rate, 0.0), place),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
        )
    axes.set_yticks(places, [one.excitation.name for one in candidates])
    axes.set(ylim=(len(candidates) - 0.4, -0.6), xlim=(0, 1.5 * max(*rates, 1e-6)))
    axes.grid(False, axis="y")
    axes.set(
        title=f"Interval of {aim.title}", xlabel="logarithm of its narrowing, a second [1/s]"
    )


def _limits(axes: Axes, limits: tuple[float, float], name: str) -> None:
    for limit, told in zip(limits, (name, None), strict=True):
        axes.axhline(limit, color=style.GREY, ls="--", lw=0.9, label=told)
