"""How well each parameter is known, relative to its value."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import percent
from identification.judge.uncertainty import UNSEEN, WEAK, ParameterEstimate


class RelativeInterval(NamedTuple):
    """A parameter's 95 % interval relative to its value."""

    name: str
    """Name and setting."""
    half_width: float
    """Half of the 95 % interval over the value's `magnitude` [1]; infinite where it isn't
    known."""
    known: str
    """How well the value is known, in words."""
    error: float | None
    """Estimate minus truth over truth [1], None where no truth is given."""
    status: str
    """What the estimate is worth."""


def relative_intervals(
    parameters: Sequence[ParameterEstimate], *, truth: dict[str, float] | None = None
) -> tuple[RelativeInterval, ...]:
    """Relative 95 % intervals of the estimated parameters.

    Args:
        parameters: The parameters; fixed ones are left out.
        truth: True values by name [SI], where they are known.

    Returns:
        One for each estimated parameter.
    """
    relative = []
    for parameter in parameters:
        if parameter.status == "fixed":
            continue
        true = (truth or {}).get(parameter.name)
        relative.append(
            RelativeInterval(
                name=shown_name(parameter),
                half_width=parameter.relative,
                known=known_to(parameter),
                error=parameter.value / true - 1 if true else None,
                status=parameter.status,
            )
        )
    return tuple(relative)


def known_to(parameter: ParameterEstimate) -> str:
    """How well a parameter is known.

    Args:
        parameter: The parameter.

    Returns:
        "±0.5 %", "may be zero", or nothing where no run shows it.
    """
    if not np.isfinite(parameter.half_width):
        return ""
    if parameter.may_be_zero:
        return "may be zero"
    return f"±{percent(parameter.half_width / abs(parameter.value))}"


def shown_name(parameter: ParameterEstimate) -> str:
    """A parameter's name in words, with its setting.

    Args:
        parameter: The parameter.

    Returns:
        "effective pretension at 350 N".
    """
    words = parameter.name.replace("_", " ")
    return words if parameter.setting is None else f"{words} at {parameter.setting}"


@style.styled
def intervals(
    parameters: Sequence[ParameterEstimate], *, truth: dict[str, float] | None = None
) -> Figure:
    """Relative 95 % intervals on a logarithmic axis: the shorter, the better known.

    Args:
        parameters: The parameters; fixed ones are left out.
        truth: True values by name [SI]; the distance from them is marked.

    Returns:
        The figure.
    """
    rows = relative_intervals(parameters, truth=truth)
    figure, (axes,) = style.panels(1, 1, height=1.4 + 0.5 * len(rows), width=5.0)
    sizes = [100 * row.half_width for row in rows if 0 < row.half_width < np.inf]
    errors = [100 * abs(row.error) for row in rows if row.error]
    least = 10 ** np.floor(np.log10(min([*sizes, *errors, 1.0])) - 0.3)
    most = max(300.0, *sizes, *errors) if sizes or errors else 300.0
    for place, row in enumerate(rows):
        end = min(max(100 * row.half_width, least), most)
        axes.plot([least, end], [place, place], color=style.BLUE, lw=7, solid_capstyle="butt")
        told = ", ".join(filter(None, (row.known, row.status.replace("_", " "))))
        axes.annotate(
            f"{row.name}: {told}",
            (0.0, place - 0.32),
            xycoords=("axes fraction", "data"),
            xytext=(2, 0),
            textcoords="offset points",
            va="center",
            # Dashed lines go behind the words, not through them.
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
            zorder=4,
        )
        if row.error:
            axes.plot(
                100 * abs(row.error), place, "X", color=style.VERMILION, ms=8, mew=0, zorder=3
            )
    for limit, text in ((WEAK, "weak"), (UNSEEN, "unidentifiable")):
        # A standard error's limit, drawn at the two of them that half an interval is about.
        axes.axvline(200 * limit, color=style.GREY, ls="--", lw=0.9)
        axes.annotate(
            text,
            (200 * limit, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center" if limit == WEAK else "left",
            color=style.GREY,
        )
    if any(row.error for row in rows):
        axes.plot(
            [],
            [],
            "X",
            color=style.VERMILION,
            ms=8,
            mew=0,
            ls="",
            label="distance from the truth",
        )
        axes.plot([], [], color=style.BLUE, lw=7, label="half of the 95 % interval")
        figure.legend(loc="outside upper right", ncols=2)
    axes.set(xscale="log", xlim=(least, 3 * most), ylim=(len(rows) - 0.6, -0.75))
    axes.set_yticks([])
    axes.tick_params(axis="y", length=0)
    axes.grid(False, axis="y")
    axes.set_xlabel("half of the 95 % interval, relative to the value [%]")
    style.decades(axes.xaxis)
    return figure
