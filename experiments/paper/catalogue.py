"""The topics of the paper in its order: all that `scdpr reproduce` computes and judges."""

import difflib
from collections.abc import Sequence

from experiments.paper import contradictions
from experiments.paper.claim import Claim
from experiments.paper.content import Section
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

TOPICS = (
    contradictions,
    prototype,
    workspaces,
    breakaway,
    knocks,
    open_loop,
    loop,
    manoeuvres,
    validity,
    smoothing,
    tensioning,
    stiffness,
    explanation,
)
"""Every topic; what our own documentation says of smoothed friction is one of them."""

SECTIONS: tuple[Section, ...] = tuple(part for topic in TOPICS for part in topic.SECTIONS)
"""Every section of the report."""

CLAIMS: tuple[Claim, ...] = tuple(claim for section in SECTIONS for claim in section.claims)
"""Every claim."""


def chosen(names: Sequence[str]) -> tuple[Section, ...]:
    """The sections of some names.

    Args:
        names: Names, in any order; none for all.

    Returns:
        The sections, in the paper's order.

    Raises:
        ValueError: If a name is unknown; the nearest known one is told.
    """
    every = [section.name for section in SECTIONS]
    for name in names:
        if name not in every:
            near = difflib.get_close_matches(name.lower(), every, n=1, cutoff=0.3)
            hint = f" Did you mean `scdpr reproduce {near[0]}`?" if near else ""
            raise ValueError(
                f"`NAME` is unknown, got {name!r}, expected one of: {', '.join(every)}.{hint}"
            )
    return tuple(section for section in SECTIONS if section.name in (names or every))
