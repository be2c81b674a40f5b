"""Section of Figure 10."""

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.breakaway.claims import FIG10
from experiments.paper.topics.breakaway.figure import draw_fig10
from experiments.paper.topics.breakaway.numbers import (
    NOMINAL,
    SPREAD,
    breakaway,
    coefficient,
    printed_force,
    unbiased_force,
)
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import value


def _coefficient(force: float, tension: float, carriages: int) -> str:
    return f"{coefficient(force, tension=tension, carriages=carriages):.4f}"


def fig10(picture: Pictures) -> Content:
    """Breakaway, thirty times.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    tight, loose = breakaway(printed_force()), breakaway(unbiased_force())
    effective = float(value(consistent(), "effective_pretension"))
    forces = (
        ("voltage as the force", printed_force()),
        ("half a step less", unbiased_force()),
    )
    return Content(
        f"Both drives at 0.68 V pull with {printed_force():.1f} N. The printed μ = 0.1723 "
        "at 350 N would hold each carriage with 241 N: at 10 V, 132 N, nothing moves.",
        "A staircase of 0.1 V finds the first step above the force, on average half a step "
        f"too high: a mean of 0.68 V belongs to {unbiased_force():.1f} N rather than "
        f"{printed_force():.1f} N. Simulated with {100 * SPREAD:.0f} % of spread for each "
        f"carriage, {loose.force:.1f} N give a mean of {loose.mean:.2f} V and "
        f"{tight.force:.1f} N one of {tight.mean:.2f} V.",
        f"The lower carriage moves first, at {loose.lower_voltage.mean():.2f} V on "
        "average: what starts at 0.68 V is the upper one, which Figure 10 shows.",
        "A μ means nothing without the tension that it was found with; what breakaway "
        "determines is the force.",
        picture(
            draw_fig10(loose, tight),
            "Left: the upper carriage at the printed voltage, the carriages' friction "
            "drawn anew in each repetition; some stay. Right: the first voltage of the "
            "staircase that moves it, thirty times.",
        ),
        table_of(
            "The coefficient of friction, with the tension that it belongs to",
            (
                {
                    "reading": reading,
                    "force [N]": f"{force:.2f}",
                    "tension [N]": f"{tension:.0f}",
                    "μ, lower carriage alone": _coefficient(force, tension, 1),
                    "μ, both": _coefficient(force, tension, 2),
                }
                for reading, force in forces
                for tension in (NOMINAL, effective)
            ),
        ),
    )


SECTIONS = (Section("fig10", "Figure 10: breakaway and friction", 6.0, fig10, FIG10),)
"""Sections of this module."""
