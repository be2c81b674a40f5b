"""Everything that `scdpr reproduce` can reproduce, in the paper's order."""

import difflib
from collections.abc import Sequence

from experiments.reproduce import contradictions
from experiments.reproduce.content import Section
from experiments.reproduce.sections import (
    breakaway,
    explanation,
    knocks,
    loop,
    manoeuvres,
    open_loop,
    prototype,
    smoothing,
    stiffness_map,
    tensioning,
    validity,
    workspaces,
)

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
