"""Sections 2.2 and 7: what the loop's tension is said to do, bare and with an actuator."""

import numpy as np

from experiments.paper.claim import Claim, Printed, at_least, at_most
from experiments.paper.topics.tensioning.numbers import creep, runs

FIG21: tuple[Claim, ...] = (
    Printed("2.2", "negligible", "1", at_most(0.1), "a tenth").not_reproducible(
        "rise of a bare loop's tension in experiment 1, over the pretension",
        lambda: float(runs().tension["no actuator"].max()) / 85 - 1,
        "E24: the path of a misaligned robot is longer; something in the rig gives way",
        heavy=True,
    ),
    Printed(
        "7, Fig. 21",
        "maintenance",
        "1",
        at_least(0.99),
        "a hundredth: half a per cent of the frequency",
    ).reproduced(
        "share of the pretension that the actuator keeps through a thousand hours of creep",
        lambda: float(np.min(creep().held) / creep().held[0]),
    ),
)
"""What sections 2.2 and 7 say of the tension."""
