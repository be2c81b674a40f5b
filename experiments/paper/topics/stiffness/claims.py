"""Section 7: what the stiffness is said to be."""

from experiments.paper.claim import Claim, Verdict, at_least, at_most
from experiments.paper.topics.stiffness.numbers import stiffness_map

CLAIMS: tuple[Claim, ...] = (
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
)
"""What section 7 says of the stiffness."""
