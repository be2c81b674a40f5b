"""What a long computation says of itself while it runs.

A computation is made of computations: a calibration of a fit, a fit of starts. None of them
knows what it is a part of, so each tells of itself from 0 to 1, and whoever calls it gives it
its place in the whole. Shares of time that are written into every callee would be simpler,
and wrong as soon as somebody else calls it.
"""

import dataclasses
import sys
import time
from collections.abc import Callable


@dataclasses.dataclass(frozen=True)
class Progress:
    """Where a computation tells what it is doing and which share of it is done."""

    tell: Callable[[str, float], None]
    """Called with what is being done and which share of the whole is done."""
    begin: float = 0.0
    """Share of the whole at which this part begins [1]."""
    end: float = 1.0
    """Share at which it ends [1]."""
    name: str = ""
    """What the part is called, before what it says itself; empty for nothing."""

    def __call__(self, doing: str, share: float) -> None:
        """Tell what is being done.

        Args:
            doing: What is being done; empty where the part's name says it.
            share: Which share of this part is done [1]; above 1 it counts as 1.
        """
        words = ": ".join(word for word in (self.name, doing) if word)
        self.tell(words, self.begin + (self.end - self.begin) * min(share, 1.0))

    def part(self, begin: float, end: float, name: str = "") -> "Progress":
        """The progress of a computation within this one.

        Args:
            begin: Share of this computation at which that one begins [1].
            end: Share at which it ends [1].
            name: What to put before what it says itself; empty for nothing.

        Returns:
            What the inner computation tells of itself, from 0 to 1.
        """
        return Progress(self, begin, end, name)


SILENT = Progress(lambda doing, share: None)
"""The progress that nobody listens to."""


def listening(progress: Progress | bool) -> Progress:
    """The progress of a computation that a notebook calls.

    Args:
        progress: The progress; True for a line in the notebook that is written over, False
            for none.

    Returns:
        What the computation tells.
    """
    if isinstance(progress, Progress):
        return progress
    return Progress(_Line()) if progress else SILENT


class _Line:
    """A line on the standard error stream, which notebooks show, and terminals too."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._width = 0
        self._share = 0.0

    def __call__(self, doing: str, share: float) -> None:
        """Write it anew: the share never falls."""
        self._share = max(self._share, share)
        passed = time.monotonic() - self._begun
        left = f", {passed / self._share - passed:.0f} s left" if self._share >= 0.1 else ""
        line = f"{100 * self._share:3.0f} %  {passed:.0f} s{left}  {doing}"
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)
        if self._share >= 1:
            sys.stderr.write("\n")
