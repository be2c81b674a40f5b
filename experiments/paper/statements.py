"""Sections 2.2, 3.2 and 7: statements that a model can test."""

import numpy as np

from experiments.paper.claim import Claim, Verdict, at_least, at_most
from experiments.paper.topics.stiffness.numbers import stiffness_map
from experiments.paper.topics.tensioning.numbers import creep, runs

STATEMENTS: tuple[Claim, ...] = (
    Claim(
        "stiffness",
        "7",
        "horizontal stiffness over the height at one pretension, largest over smallest",
        "invariant",
        "1",
        at_most(1.1),
        "a tenth",
        lambda: stiffness_map().loop_ratio,
        Verdict.NOT_REPRODUCIBLE,
        "(20): 1/z₁ + 1/z₂ depends on the height; over the width it is invariant",
    ),
    Claim(
        "stiffness",
        "7",
        "the conventional robot's variation over the single loop's",
        "larger",
        "1",
        at_least(1.0),
        "the better one varies less",
        lambda: stiffness_map().conventional_ratio / stiffness_map().loop_ratio,
        Verdict.REPRODUCED,
        "though it is hundreds of times as stiff everywhere",
    ),
    Claim(
        "fig21",
        "2.2",
        "rise of a bare loop's tension in experiment 1, over the pretension",
        "negligible",
        "1",
        at_most(0.1),
        "a tenth",
        lambda: float(runs().tension["no actuator"].max()) / 85 - 1,
        Verdict.NOT_REPRODUCIBLE,
        "E24: the path of a misaligned robot is longer; something in the rig gives way",
        heavy=True,
    ),
    Claim(
        "fig21",
        "7, Fig. 21",
        "share of the pretension that the actuator keeps through a thousand hours of creep",
        "maintenance",
        "1",
        at_least(0.99),
        "a hundredth: half a per cent of the frequency",
        lambda: float(np.min(creep().held) / creep().held[0]),
        Verdict.REPRODUCED,
    ),
)
"""Statements of sections 2.2 and 7."""
