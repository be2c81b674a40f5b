"""One list of every number that the paper prints, and of what we say of smoothed friction."""

from experiments.paper.claim import Claim
from experiments.paper.statements import STATEMENTS
from experiments.paper.topics.breakaway.claims import BREAKAWAY
from experiments.paper.topics.knocks.claims import FREQUENCIES
from experiments.paper.topics.loop.claims import LOOP
from experiments.paper.topics.manoeuvres.claims import MANOEUVRES
from experiments.paper.topics.open_loop.claims import OPEN_LOOP
from experiments.paper.topics.prototype.claims import PROTOTYPE
from experiments.paper.topics.smoothing.claims import SMOOTHING
from experiments.paper.topics.workspaces.claims import WORKSPACE

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
