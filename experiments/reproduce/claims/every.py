"""One list of every number that the paper prints, and of what we say of smoothed friction."""

from experiments.reproduce.claim import Claim
from experiments.reproduce.claims.breakaway import BREAKAWAY
from experiments.reproduce.claims.frequencies import FREQUENCIES
from experiments.reproduce.claims.loop import LOOP
from experiments.reproduce.claims.manoeuvres import MANOEUVRES
from experiments.reproduce.claims.open_loop import OPEN_LOOP
from experiments.reproduce.claims.prototype import PROTOTYPE
from experiments.reproduce.claims.smoothing import SMOOTHING
from experiments.reproduce.claims.statements import STATEMENTS
from experiments.reproduce.claims.workspace import WORKSPACE

CLAIMS: tuple[Claim, ...] = (
    *WORKSPACE,
    *PROTOTYPE,
    *BREAKAWAY,
    *FREQUENCIES,
    *OPEN_LOOP,
    *LOOP,
    *MANOEUVRES,
    *STATEMENTS,
    *SMOOTHING,
)
"""Every claim, in the paper's order; last those of our own documentation."""


def of_section(name: str) -> tuple[Claim, ...]:
    """The claims of a section of the report.

    Args:
        name: The section's name.

    Returns:
        Its claims, in the paper's order.
    """
    return tuple(claim for claim in CLAIMS if claim.section == name)
