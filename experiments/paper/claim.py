"""A number that the paper prints, what this software makes of it, and the verdict."""

import dataclasses
import enum
import math
from collections.abc import Callable


class Verdict(enum.Enum):
    """What becomes of a printed number."""

    GIVEN = "taken as given"
    """A measured or chosen input: nothing to compute, and the robot holds it as printed."""
    REPRODUCED = "reproduced"
    """Computed here from the paper's other numbers, within the tolerance."""
    AFTER_ERRATUM = "reproduced after an erratum"
    """Within the tolerance once a misprint of `docs/errata.md` is put right."""
    NOT_REPRODUCIBLE = "not reproducible"
    """Outside the tolerance, for the reason that is told."""


@dataclasses.dataclass(frozen=True)
class Claim:
    """One printed number with the verdict on it."""

    section: str
    """Name of the section of the report that it belongs to."""
    where: str
    """Where it is printed."""
    what: str
    """What is claimed."""
    printed: str
    """As it is printed."""
    unit: str
    """Its unit, "1" for none."""
    accepted: tuple[float, float]
    """Smallest and largest number that still says the same."""
    reason: str
    """Why so far and no further."""
    compute: Callable[[], float]
    """What this software makes of it."""
    verdict: Verdict
    """The verdict."""
    because: str = ""
    """Why, for a reader; the erratum's id where there is one."""
    heavy: bool = False
    """Whether computing it takes a simulation of many runs."""

    @property
    def name(self) -> str:
        """Where and what, in one line."""
        return f"{self.where}: {self.what}"

    def agrees(self, ours: float) -> bool:
        """Whether a number says what the paper says.

        Args:
            ours: The number.

        Returns:
            Whether it lies within the tolerance.
        """
        low, high = self.accepted
        return low <= ours <= high

    def stands(self, ours: float) -> bool:
        """Whether the verdict is the right one for a number.

        Args:
            ours: The number.

        Returns:
            Whether it agrees, for the verdicts that say so; whether it doesn't, for the
            other.
        """
        return self.agrees(ours) == (self.verdict is not Verdict.NOT_REPRODUCIBLE)


def digits(printed: str) -> tuple[float, float]:
    """What rounds to a printed number: half a unit of its last digit to either side.

    Args:
        printed: The number, "3.9".

    Returns:
        Smallest and largest number that it may stand for.
    """
    mantissa, _, exponent = printed.partition("e")
    _, _, decimals = mantissa.partition(".")
    unit = 10.0 ** (int(exponent or 0) - len(decimals))
    # Numbers that sit on the border are rounded either way; so are their last bits.
    half = 0.5 * unit * (1 + 1e-9)
    return float(printed) - half, float(printed) + half


def within(value: float, tolerance: float) -> tuple[float, float]:
    """A number and what is as good.

    Args:
        value: The number.
        tolerance: How far from it, to either side.

    Returns:
        Smallest and largest accepted number.
    """
    return value - tolerance, value + tolerance


def at_least(value: float) -> tuple[float, float]:
    """A number and all above it.

    Args:
        value: The number.

    Returns:
        Smallest and largest accepted number.
    """
    return value, math.inf


def at_most(value: float) -> tuple[float, float]:
    """A number and all below it.

    Args:
        value: The number.

    Returns:
        Smallest and largest accepted number.
    """
    return -math.inf, value


AS_PRINTED = "to the last printed digit"
"""The reason of a tolerance that is the print's own rounding."""
