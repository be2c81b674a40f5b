"""The topics of the paper in its order: all that `scdpr reproduce` computes and judges."""

import difflib
from collections.abc import Sequence

from experiments.paper import contradictions
from experiments.paper.claim import Claim
from experiments.paper.content import Section, Topic
from experiments.paper.topics import (
    breakaway,
    explanation,
    knocks,
    loop,
    manoeuvres,
    open_loop,
    prototype,
    smoothing,
    stiffness,
    tensioning,
    validity,
    workspaces,
)

TOPICS: tuple[Topic, ...] = (
    Topic(contradictions.SECTIONS),
    Topic(prototype.SECTIONS, prototype.CLAIMS),
    Topic(workspaces.SECTIONS, workspaces.CLAIMS),
    Topic(breakaway.SECTIONS, breakaway.CLAIMS),
    Topic(knocks.SECTIONS, knocks.CLAIMS),
    Topic(open_loop.SECTIONS, open_loop.CLAIMS),
    Topic(loop.SECTIONS, loop.CLAIMS),
    Topic(manoeuvres.SECTIONS, manoeuvres.CLAIMS),
    Topic(validity.SECTIONS),
    Topic(smoothing.SECTIONS, smoothing.CLAIMS),
    Topic(tensioning.SECTIONS, tensioning.CLAIMS),
    Topic(stiffness.SECTIONS, stiffness.CLAIMS),
    Topic(explanation.SECTIONS),
)
"""Every topic; what our own documentation says of smoothed friction is one of them."""

SECTIONS: tuple[Section, ...] = tuple(part for topic in TOPICS for part in topic.sections)
"""Every section of the report."""

CLAIMS: tuple[Claim, ...] = tuple(claim for topic in TOPICS for claim in topic.claims)
"""Every claim."""


def of_section(name: str) -> tuple[Claim, ...]:
    """The claims of a section of the report.

    Args:
        name: The section's name.

    Returns:
        Its claims, in the paper's order.
    """
    return tuple(claim for claim in CLAIMS if claim.section == name)


def chosen(names: Sequence[str]) -> tuple[Section, ...]:
    """The sections of some names.

    Args:
        names: Names, in any order; none for all.

    Returns:
        The sections, in the paper's order.

    Raises:
        ValueError: If a name is unknown; the nearest known one is told.
    """
    known = [section.name for section in SECTIONS]
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.3)
            hint = f" Did you mean `scdpr reproduce {near[0]}`?" if near else ""
            raise ValueError(
                f"`NAME` is unknown, got {name!r}, expected one of: {', '.join(known)}.{hint}"
            )
    wanted = set(names or known)
    return tuple(section for section in SECTIONS if section.name in wanted)
