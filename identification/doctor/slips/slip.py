"""A slip: one thing that people get wrong, and how it is undone in memory."""

import dataclasses
from collections.abc import Callable

from identification.doctor.case import Case
from identification.doctor.slips.edits import Undone


@dataclasses.dataclass(frozen=True)
class Slip:
    """One thing that people get wrong."""

    id: str
    """Its identifier."""
    what: str
    """What happened, more exactly than the identifier says."""
    undo: Callable[[Case], Undone | None]
    """The case without it; None where the case has nothing to estimate it from."""
