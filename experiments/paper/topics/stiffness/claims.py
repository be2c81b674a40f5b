"""Section 7: what the stiffness is said to be."""

from experiments.paper.claim import Claim, Printed, at_least, at_most
from experiments.paper.topics.stiffness.numbers import stiffness_map

STIFFNESS: tuple[Claim, ...] = (
    Printed("7", "invariant", "1", at_most(1.1), "a tenth").not_reproducible(
        "horizontal stiffness over the height at one pretension, largest over smallest",
        lambda: stiffness_map().loop_ratio,
        "(20): 1/z₁ + 1/z₂ depends on the height; over the width it is invariant",
    ),
    Printed("7", "larger", "1", at_least(1.0), "the better one varies less").reproduced(
        "the conventional robot's variation over the single loop's",
        lambda: stiffness_map().conventional_ratio / stiffness_map().loop_ratio,
        "though it is hundreds of times as stiff everywhere",
    ),
)
"""What section 7 says of the stiffness."""
