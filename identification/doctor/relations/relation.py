"""A relation between two sensors, or between a sensor and the rig, and how well it holds."""

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

HOPELESS = 14.0
"""Severity of a relation that is off without bounds."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Relation:
    """What two sensors say of each other in the runs of a case."""

    name: str
    """What is held against what: "slope.y"."""
    excess: float
    """How far it is off, over what good campaigns reach with a margin: up to 1 it holds."""
    what: str
    """The figures in words: "camera y_e over encoder y: slope 1.0002 ± 0.0001"."""
    figures: dict[str, Any]
    """The figures [SI]."""

    @property
    def broken(self) -> bool:
        """Whether it doesn't hold."""
        return self.excess > 1

    @property
    def severity(self) -> float:
        """How much it counts against a hypothesis: nothing if it holds."""
        if not self.broken:
            return 0.0
        return 0.3 + math.log(self.excess) if self.excess < 1e6 else HOPELESS


def severity(relations: Iterable[Relation]) -> float:
    """How much all relations count against a hypothesis.

    Args:
        relations: The relations.

    Returns:
        The sum of their severities, 0 if all hold.
    """
    return sum((relation.severity for relation in relations), 0.0)


def off(ratio: float, factor: float) -> float:
    """Excess of a ratio that should be 1, and may be off by a factor either way.

    Args:
        ratio: The ratio.
        factor: What it may be off by.

    Returns:
        The excess.
    """
    return min(abs(math.log(max(ratio, 1e-13))), 30.0) / math.log(factor)
