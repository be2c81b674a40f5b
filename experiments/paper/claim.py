"""Numbers that the paper prints, what this software makes of them, and the verdicts."""

import dataclasses
import enum
import functools
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
class Printed:
    """A number as the paper prints it, and what says the same."""

    where: str
    """Where it is printed."""
    text: str
    """As it is printed."""
    unit: str
    """Its unit, "1" for none."""
    tolerance: tuple[float, float] | None = None
    """Smallest and largest number that still says the same; None for all that round to it."""
    reason: str = "to the last printed digit"
    """Why so far and no further."""

    @property
    def accepted(self) -> tuple[float, float]:
        """Smallest and largest number that still says the same."""
        return self.tolerance or digits(self.text)

    def _claim(
        self,
        verdict: Verdict,
        what: str,
        compute: Callable[[], float],
        because: str = "",
        *,
        heavy: bool = False,
    ) -> "Claim":
        return Claim(self, what, compute, verdict, because, heavy)

    given = functools.partialmethod(_claim, Verdict.GIVEN)
    reproduced = functools.partialmethod(_claim, Verdict.REPRODUCED)
    after_erratum = functools.partialmethod(_claim, Verdict.AFTER_ERRATUM)
    not_reproducible = functools.partialmethod(_claim, Verdict.NOT_REPRODUCIBLE)
    """Readings of the number by their verdict: `what`, `compute`, `because`, `heavy`."""


@dataclasses.dataclass(frozen=True)
class Claim:
    """One reading of a printed number, with the verdict on it."""

    printed: Printed
    """The number."""
    what: str
    """What is claimed."""
    compute: Callable[[], float]
    """What this software makes of it."""
    verdict: Verdict
    """The verdict."""
    because: str
    """Why, for a reader; the erratum's id where there is one."""
    heavy: bool
    """Whether computing it takes a simulation of many runs."""

    @property
    def name(self) -> str:
        """Where and what, in one line."""
        return f"{self.printed.where}: {self.what}"

    def agrees(self, ours: float) -> bool:
        """Whether a number says what the paper says.

        Args:
            ours: The number.

        Returns:
            Whether it lies within the tolerance.
        """
        low, high = self.printed.accepted
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
