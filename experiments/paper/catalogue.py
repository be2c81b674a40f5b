"""Everything that `scdpr reproduce` can reproduce, in the paper's order."""

import difflib
from collections.abc import Sequence

from experiments.paper import contradictions
from experiments.paper.content import Section
from experiments.paper.topics.breakaway import section as breakaway
from experiments.paper.topics.explanation import section as explanation
from experiments.paper.topics.knocks import section as knocks
from experiments.paper.topics.loop import section as loop
from experiments.paper.topics.manoeuvres import section as manoeuvres
from experiments.paper.topics.open_loop import section as open_loop
from experiments.paper.topics.prototype import section as prototype
from experiments.paper.topics.smoothing import section as smoothing
from experiments.paper.topics.stiffness import section as stiffness_map
from experiments.paper.topics.tensioning import section as tensioning
from experiments.paper.topics.validity import section as validity
from experiments.paper.topics.workspaces import section as workspaces

SECTIONS: tuple[Section, ...] = (
    *contradictions.SECTIONS,
    *prototype.SECTIONS,
    *workspaces.SECTIONS,
    *breakaway.SECTIONS,
    *knocks.SECTIONS,
    *open_loop.SECTIONS,
    *loop.SECTIONS,
    *manoeuvres.SECTIONS,
    *validity.SECTIONS,
    *smoothing.SECTIONS,
    *tensioning.SECTIONS,
    *stiffness_map.SECTIONS,
    *explanation.SECTIONS,
)
"""Every section of the report."""


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
