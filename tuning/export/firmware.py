"""A shaper as a printer's firmware is told of it: the lines to paste.

A firmware makes its impulses itself, from a type, a frequency and a damping ratio; an optimised
shaper has no such line. So the lines are of the catalogue's shaper that one would take of
those that the firmware knows, which is said. The formats are those that the documentation of
Klipper's `[input_shaper]` section and of Marlin's `M593` gives.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from tuning.shapers.comparison import Fitted, pick

KLIPPER = ("zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei")
"""Types of Klipper's `shaper_type`, by the catalogue's names."""
MARLIN = ("zv",)
"""What Marlin's `M593` runs: a ZV shaper of the frequency and damping ratio that it is told."""
IMPULSES = {"klipper": 5, "marlin": 2}
"""The most impulses that a firmware makes: of Klipper's 3hump_ei, of Marlin's ZV."""


class Pasted(NamedTuple):
    """Lines for a firmware."""

    firmware: str
    """Its name."""
    lines: tuple[str, ...]
    """What to paste."""
    fit: Fitted
    """The catalogue's shaper that they are."""

    @property
    def document(self) -> dict[str, Any]:
        """The same as `shaper.json` has it."""
        return {"kind": self.fit.entry.name, "lines": list(self.lines)}


def pasted(fits: Sequence[Fitted], *, axis: str, damping_ratio: float) -> tuple[Pasted, ...]:
    """Lines for each firmware.

    Args:
        fits: The catalogue's shapers, each at its best frequency.
        axis: "x" or "y".
        damping_ratio: Damping ratio that they are designed for [1].

    Returns:
        For each firmware the lines of the shaper that one would take of those that it knows.
    """
    made = []
    for firmware, known, lines in (("Klipper", KLIPPER, _klipper), ("Marlin", MARLIN, _marlin)):
        able = [fit for fit in fits if fit.entry.name in known]
        if able:
            # Of a single one there is nothing to pick.
            best = pick(able) if len(able) > 1 else able[0]
            made.append(Pasted(firmware, lines(best, axis, damping_ratio), best))
    return tuple(made)


def _klipper(fit: Fitted, axis: str, damping_ratio: float) -> tuple[str, ...]:
    return (
        "[input_shaper]",
        f"shaper_type_{axis}: {fit.entry.name}",
        f"shaper_freq_{axis}: {fit.frequency:.1f}",
        f"damping_ratio_{axis}: {damping_ratio:g}",
    )


def _marlin(fit: Fitted, axis: str, damping_ratio: float) -> tuple[str, ...]:
    return (f"M593 {axis.upper()} F{fit.frequency:.2f} D{damping_ratio:g}",)
