"""Sections of Table 2 and Figures 13 and 14."""

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.open_loop.claims import FIG14, TABLE2
from experiments.paper.topics.open_loop.figure import draw_fig13, draw_fig14, draw_table2
from experiments.paper.topics.open_loop.numbers import POSES, TITLES, TORQUES, open_loop
from scdpr_jax.robot.state import pose


def table2(picture: Pictures) -> Content:
    """The four experiments.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    runs, narrow = open_loop(), open_loop(7.3e-3)
    rows = (
        {
            "experiment": TITLES[index],
            "start [m]": f"[{POSES[index][0]:.3f}, {POSES[index][1]:.3f}]",
            "torques [N m]": f"[{TORQUES[index][0]:.2f}, {TORQUES[index][1]:.2f}]",
            "rests at [m]": "[{:.3f}, {:.3f}]".format(*pose(runs.position[index, -1])),
            "travel [mm]": f"{1e3 * runs.travel(index + 1):.0f}",
            "least distance to the frame [mm]": f"{1e3 * runs.margin(index + 1):.0f}",
            "travel at r = 7.3 mm [mm]": f"{1e3 * narrow.travel(index + 1):.0f}",
        }
        for index in range(len(POSES))
    )
    return Content(
        "Every experiment crosses the frame and stays inside it, as the paper says it was "
        "chosen to; with the printed radius none goes further than some 15 cm.",
        "Experiments 3 and 4 decide between (2) and the printed (3): τ₁ > 0 > τ₂ goes up "
        "from y = 0.234 m, where there is no room to go down.",
        picture(
            draw_table2(runs),
            "What the end-effector does in the four experiments: a second of torque, then "
            "coasting.",
        ),
        table_of("Table 2, simulated", rows),
    )


def fig13(picture: Pictures) -> Content:
    """Experiment 1.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    runs = open_loop()
    first = runs.position[0]
    lag = 1e3 * abs(first[:, 0] - first[:, 2]).max()
    return Content(
        f"Experiment 1 runs from x = 0.173 m to {first[-1, 0]:.2f} m; the end-effector "
        f"lags the driven carriage by {lag:.0f} mm at most and both carriages come to "
        "rest.",
        "The text prints no number of Figure 13 to compare with.",
        picture(draw_fig13(runs), "Experiment 1 of Table 2: positions over time."),
    )


def fig14(picture: Pictures) -> Content:
    """Torques.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    return Content(
        "The 4.85 N m of experiment 1 are more than the drives have at their 10 V: 4.82 N "
        "m by (24), 4.71 N m by the nameplates. The model saturates the command.",
        picture(draw_fig14(open_loop()), "Torques of the four experiments of Table 2."),
    )


SECTIONS = (
    Section("table2", "Table 2: open-loop experiments", 4.0, table2, TABLE2),
    Section("fig13", "Figure 13: experiment 1", 0.5, fig13),
    Section("fig14", "Figure 14: torques", 0.5, fig14, FIG14),
)
"""Sections of this module."""
