"""Where the paper's numbers contradict each other, one line each, to check by hand."""

import dataclasses
import math

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section


@dataclasses.dataclass(frozen=True)
class Contradiction:
    """Two numbers of the paper that should be one."""

    sum: str
    """What to compute, with the paper's numbers in it."""
    comes_to: float
    """What it comes to."""
    printed: str
    """What is printed for it, and where."""
    number: float
    """That number."""
    unit: str
    """Unit of both."""
    erratum: str
    """Row of `docs/errata.md`."""


CONTRADICTIONS: tuple[Contradiction, ...] = (
    Contradiction(
        "2 J/r² = 2 · 0.012734 / 0.0073²",
        2 * 0.012734 / 0.0073**2,
        "moving masses of (19), 2.1 + 1.2 + 1.2",
        2.1 + 1.2 + 1.2,
        "kg",
        "E1",
    ),
    Contradiction(
        "diagonal, mid-leg: b/k_v · 1.5 (2.07 + 0.73)/(0.0073 · 2.5), b/k_v = 0.2124/0.482",
        0.2124 / 0.482 * 1.5 * (2.07 + 0.73) / (0.0073 * 2.5),
        "limit of the command, 5.1",
        10.0,
        "V",
        "E1",
    ),
    Contradiction("1/J = 1/0.012734", 1 / 0.012734, "numerator, (24)", 2169.0, "1/s²/V", "E8"),
    Contradiction("b/J = 0.2/0.012734", 0.2 / 0.012734, "pole, (24)", 16.68, "1/s", "E11"),
    Contradiction(
        "0.68 V · 0.6 A/V · 0.0302 N m/A · 26",
        0.68 * 0.6 * 0.0302 * 26,
        "τ_f, 5.1 (and 0.3268 below it)",
        0.3284,
        "N m",
        "E12",
    ),
    Contradiction(
        "10 V · 0.6 A/V · 0.0302 N m/A · 26",
        10 * 0.6 * 0.0302 * 26,
        "torque of experiment 1, Table 2",
        4.85,
        "N m",
        "E20",
    ),
    Contradiction(
        "friction of one carriage, 4 T μ = 4 · 350 · 0.1723",
        4 * 350 * 0.1723,
        "force of both drives at breakaway, 2 τ_f/r = 2 · 0.3284/0.073",
        2 * 0.3284 / 0.073,
        "N",
        "E21",
    ),
    Contradiction(
        "K_d for 60°: 0.6352 · tan(60° − 90° + atan(40/16.68))/40",
        0.6352 * math.tan(math.atan(40 / 16.68) - math.pi / 6) / 40,
        "K_d, (25)",
        0.0125,
        "V s/°",
        "E10",
    ),
    Contradiction(
        "Eq. (1): (2224 − 287)(1112 − 281)/(2224 · 1112) · 100",
        100 * (2224 - 287) * (1112 - 281) / (2224 * 1112),
        "conventional robot's share, 2.1, which it is to gain upon",
        70.73,
        "%",
        "E29",
    ),
    Contradiction(
        "stretch of the loop, 350 · 8.334/(2.0912e9 · π · 0.001²)",
        350 * 8.334 / (2.0912e9 * math.pi * 0.001**2),
        "length variation “negligible”, 2.2",
        0.0,
        "m",
        "E14",
    ),
    Contradiction(
        "half a carriage, 0.287/2, the least x of (1)",
        0.287 / 2,
        "intermediate x of the diagonal, Table 3",
        0.01,
        "m",
        "E17",
    ),
    Contradiction(
        "redundancy of Figure 2's robot, m − n = 3 − 4",
        3 - 4.0,
        "r of a fully constrained robot, 1",
        1.0,
        "1",
        "E33",
    ),
    Contradiction(
        "height of the end-effector, 2.1, 0.287 mm",
        0.287,
        "the same, Table 1",
        281.0,
        "mm",
        "E13",
    ),
    Contradiction(
        "first mode of (18) with K of (20), T = 200 N, y = H/2: sway between held carriages, "
        "√(2T · 2/0.4155/2.1)/2π",
        (2 * 200 * 2 / 0.4155 / 2.1) ** 0.5 / (2 * math.pi),
        "natural frequency at 200 N, 5.2",
        2.4,
        "Hz",
        "E22",
    ),
)
"""Every contradiction that a pocket calculator shows."""


def contradictions(picture: Pictures) -> Content:
    """The contradictions, one line each.

    Args:
        picture: The page's figures; none is drawn.

    Returns:
        The section.
    """
    rows = (
        {
            "compute": each.sum,
            "it comes to": f"{each.comes_to:.4g}",
            "against": f"{each.number:.4g}",
            "unit": each.unit,
            "which is": each.printed,
            "erratum": each.erratum,
        }
        for each in CONTRADICTIONS
    )
    return Content(
        "Each line can be checked with a pocket calculator and the paper alone.",
        table_of("The paper against itself", rows),
    )


SECTIONS = (
    Section("contradictions", "Where the paper contradicts itself", 0.1, contradictions),
)
"""The section of this module."""
