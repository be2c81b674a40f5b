"""Figure 21: creep with and without the actuator, and the tension in experiment 1."""

from matplotlib.figure import Figure

from experiments.page import style
from experiments.paper.topics.tensioning.numbers import Creep, Runs


@style.styled
def draw_creep(numbers: Creep) -> Figure:
    """Pretension and frequency over a thousand hours.

    Args:
        numbers: The histories.

    Returns:
        The figure.
    """
    figure, (tension, frequency) = style.panels(1, 2, height=3.2)
    lines = [
        (values, colour, f"steel, {1e6 * strain:g} µm/m a decade")
        for (strain, values), colour in zip(
            numbers.bare.items(), (style.SKY, style.BLUE, style.VERMILION), strict=True
        )
    ]
    lines += [
        (numbers.printed, style.ORANGE, "printed E, the largest creep"),
        (numbers.held, style.GREEN, "steel, the largest creep, held"),
    ]
    shown = numbers.hours > 0
    for values, colour, name in lines:
        tension.semilogx(numbers.hours[shown], values[shown], color=colour, label=name)
        left = (values[shown] / values[0]) ** 0.5
        frequency.semilogx(numbers.hours[shown], 100 * left, color=colour)
    for axes in (tension, frequency):
        axes.set_xlabel("time under load [h]")
        style.decades(axes.xaxis)
    tension.set_ylabel("pretension [N]")
    frequency.set_ylabel("natural frequency left [%]")
    style.legend_above(tension, columns=2)
    return figure


@style.styled
def draw_tensions(numbers: Runs) -> Figure:
    """Tension and actuator in experiment 1.

    Args:
        numbers: The runs.

    Returns:
        The figure.
    """
    figure, (tension, travel) = style.panels(1, 2, height=3.2)
    for (name, values), colour in zip(
        numbers.tension.items(), (style.VERMILION, style.ORANGE, style.BLUE), strict=True
    ):
        tension.plot(*style.thinned(numbers.time, values), color=colour, label=name)
        travel.plot(*style.thinned(numbers.time, 1e3 * numbers.travel[name]), color=colour)
    tension.axhline(85, color=style.BLACK, ls="--", lw=1, label="constant tension")
    tension.set_ylabel("tension in experiment 1 [N]")
    travel.axhline(1e3 * numbers.path, color=style.GREY, ls="--", lw=1)
    travel.set_ylabel("travel of the actuator [mm]")
    for axes in (tension, travel):
        axes.set_xlabel("time [s]")
    style.legend_above(tension, columns=2)
    return figure
