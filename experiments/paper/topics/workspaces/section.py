"""Sections of Figures 3 and 6."""

import math

import numpy as np

from experiments.page.page import Pictures
from experiments.page.table import Table, table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.workspaces.claims import FIG3, FIG6
from experiments.paper.topics.workspaces.figure import draw_fig3, draw_fig6
from experiments.paper.topics.workspaces.numbers import (
    HEIGHT,
    PRINTED,
    WIDTH,
    Cables,
    workspaces,
)
from scdpr_jax.robot.prototype import consistent


def _tension(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else "none is enough"


def _inside(width: float, height: float) -> float:
    """Share of the frame's area that keeps the upright end-effector inside [1]."""
    frame = consistent().frame
    return (1 - width / float(frame.width)) * (1 - height / float(frame.height))


def _needs(end_effector: str, cables: Cables) -> dict[str, str]:
    return {
        "end-effector w × h [mm]": end_effector,
        "cables": "crossed" if cables.crossed else "open",
        "T_min [N]": f"{cables.minimum:g}",
        "printed [%]": f"{100 * PRINTED[cables.minimum]:.2f}",
        "T_max for it [N]": _tension(cables.maximum_for(PRINTED[cables.minimum])),
        "most, any T_max [%]": f"{100 * cables.share(math.inf):.1f}",
    }


def fig3(picture: Pictures) -> Content:
    """The conventional robot's workspace.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    robots = workspaces()
    sizes = {"281 × 287, 2.1": robots, "287 × 281, Table 1": workspaces(0.287, 0.281)}
    return Content(
        "The paper prints two percentages and no T_max. No single T_max gives both: open "
        "cables reach 41.56 % at 287 N and never 70.73 %; crossed ones need 93 N and 151 "
        "N.",
        "Crossed cables reach 70.73 % only with poses at which the end-effector sticks "
        f"out of the frame: only {100 * _inside(WIDTH, HEIGHT):.1f} % of the frame's area "
        "keep it inside.",
        "Poses are held upright against 2 kg and gravity with every cable between T_min "
        "and T_max (wrench feasibility); shares are of the frame's area, as printed.",
        picture(
            draw_fig3(robots),
            "Static workspace of the conventional robot: the largest tension that a pose "
            "needs at least, for open and crossed cables and both least tensions.",
        ),
        table_of(
            "The T_max that each printed percentage would need",
            (_needs(size, cables) for size, each in sizes.items() for cables in each.cables),
        ),
    )


def fig6(picture: Pictures) -> Content:
    """The single loop's workspace and the fair comparison.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    robots = workspaces()
    rows = tuple(
        (
            cables.name,
            *(
                f"{100 * cables.reachable_share(t):.1f}"
                for t in (100.0, 200.0, 300.0, math.inf)
            ),
        )
        for cables in robots.cables
    )
    return Content(
        f"Expression (1) with Table 1 is {100 * robots.loop_share:.1f} % of the frame's "
        "area, less than the conventional robot's printed 70.73 %: measured by the frame "
        "there is no gain.",
        "Measured by the poses whose end-effector lies inside the frame the single loop "
        "has all of them at any tension, and that is the gain; the conventional robot has "
        "what its T_max allows.",
        picture(
            draw_fig6(robots),
            "Left: the single loop's workspace in the frame. Right: share of the "
            "geometrically reachable poses over the largest tension.",
        ),
        Table(
            "Share of the reachable poses [%]",
            ("robot", "T_max 100 N", "200 N", "300 N", "without limit"),
            (*rows, ("single loop", *(f"{100 * robots.loop_reachable:.1f}",) * 4)),
        ),
    )


SECTIONS = (
    Section("fig3", "Figure 3: workspace of the conventional robot", 4.0, fig3, FIG3),
    Section("fig6", "Figure 6: workspace of the single loop", 1.0, fig6, FIG6),
)
"""Sections of this module."""
