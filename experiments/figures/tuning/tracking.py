"""A manoeuvre under control before and after tuning, each run's lag taken off."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import plain
from experiments.studies.legs.in_space import InSpace, in_space
from scdpr_jax.legs.leg import Leg

SIDES = (("before", style.VERMILION, 1.3), ("after", style.BLUE, 1.7))
"""Both sides' names, colours and widths of their lines."""


@style.styled
def tracking(before: Leg, after: Leg, *, voltage_limit: float) -> Figure:
    """Position, error, rest after the arrival, and commands, before and after.

    Args:
        before: With the controller and reference as they were.
        after: With the tuned ones.
        voltage_limit: Largest command of either sign [V].

    Returns:
        The figure.
    """
    figure, (position, error, rest, command) = style.panels(2, 2, height=6.4)
    axis = int(np.ptp(before.reference[:, 1]) > np.ptp(before.reference[:, 0]))
    position.plot(
        *style.thinned(before.time, 1e3 * before.reference[:, axis]),
        color=style.BLACK,
        lw=1.0,
        ls="--",
        zorder=3,
        label="reference",
    )
    for run, (name, color, width) in zip((before, after), SIDES, strict=True):
        placed = in_space(run)
        position.plot(
            *style.thinned(placed.time, 1e3 * placed.pose[:, axis]),
            color=color,
            lw=width,
            label=lagging(name, placed),
        )
        error.plot(*style.thinned(placed.time, 1e3 * placed.distance), color=color, lw=width)
        late = placed.time >= placed.arrival
        since = placed.time[late] - placed.arrival
        rest.plot(*style.thinned(since, 1e3 * placed.off[late, 0]), color=color, lw=width)
        draw_commands(command, run.time, run.voltage, color=color)
    rest.axhline(0, color=style.BLACK, lw=0.8, ls="--")
    name_commands(command, voltage_limit=voltage_limit)
    clock = "time of the reference [s]"
    _name(position, "position", f"{('xₑ', 'yₑ')[axis]} [mm]", clock)
    _name(error, "distance from the reference, lag taken off", "distance [mm]", clock)
    _name(rest, "after the arrival", "xₑ from the target [mm]", "time after the arrival [s]")
    error.set_ylim(bottom=0)
    style.figure_legend(figure, position)
    return figure


def lagging(name: str, placed: InSpace) -> str:
    """A run's name with the lag that was taken off.

    Args:
        name: Its name.
        placed: The run.

    Returns:
        "after, 0.43 s behind".
    """
    return f"{name}, {plain(placed.lag)} s behind"


def draw_commands(
    axes: Axes,
    time: Float[np.ndarray, " samples"],
    voltage: Float[np.ndarray, "samples-1 2"],
    *,
    color: str,
) -> None:
    """Draw the commands of both drives.

    Args:
        axes: Where to draw them.
        time: Times of the samples [s].
        voltage: Commands between them [V].
        color: Their colour.
    """
    for motor, dashes in enumerate(("-", (0, (3, 1.5)))):
        axes.plot(*style.thinned(time[:-1], voltage[:, motor]), color=color, ls=dashes, lw=1.1)


def name_commands(axes: Axes, *, voltage_limit: float) -> None:
    """Draw the drives' limits beside their commands, and name the axes.

    Args:
        axes: Where the commands are.
        voltage_limit: Largest command of either sign [V].
    """
    for limit in (-voltage_limit, voltage_limit):
        axes.axhline(limit, color=style.GREY, ls="--", lw=1)
    _name(axes, "commands and their limits", "V₁ (solid), V₂ (dashed) [V]", "time [s]")


def _name(axes: Axes, title: str, name: str, clock: str) -> None:
    axes.set(title=title, ylabel=name, xlabel=clock)
