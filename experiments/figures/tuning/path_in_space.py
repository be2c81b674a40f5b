"""Where the end-effector went, and how far that is from where it was to go."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.figures.tuning.tracking import SIDES
from experiments.page import style
from experiments.studies.legs.in_space import InSpace


@style.styled
def path_in_space(before: InSpace, after: InSpace, *, names: Sequence[str]) -> Figure:
    """The way over the workspace, and by how much it is off, in every direction.

    Args:
        before: The manoeuvre with the controller and reference as they were.
        after: With the tuned ones.
        names: What both are called.

    Returns:
        The figure.
    """
    figure, (way, off) = style.panels(1, 2, height=3.5)
    for run, name, (_, color, line) in zip((before, after), names, SIDES, strict=True):
        kept = np.linspace(0, len(run.pose) - 1, style.DRAWN_POINTS).astype(int)
        way.plot(*(1e3 * run.pose[kept]).T, color=color, lw=line, label=name)
        off.plot(*(1e3 * run.off[kept]).T, color=color, lw=line)
        off.plot(*(1e3 * run.off[-1]), "o", color=color, ms=7, mec=style.BLACK, zorder=4)
    kept = np.linspace(0, len(before.reference) - 1, style.DRAWN_POINTS).astype(int)
    way.plot(
        *(1e3 * before.reference[kept]).T,
        color=style.BLACK,
        lw=1.0,
        ls="--",
        label="reference",
        zorder=3,
    )
    for draw in (off.axhline, off.axvline):
        draw(0, color=style.GREY, lw=0.7)
    way.set(title="the path", xlabel="xₑ [mm]", ylabel="yₑ [mm]")
    off.set(
        title="deviation; dots: where it rests",
        xlabel="across the frame [mm]",
        ylabel="upwards [mm]",
    )
    style.figure_legend(figure, way)
    return figure
