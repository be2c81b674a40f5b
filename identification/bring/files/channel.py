"""A channel of a log: its numbers, and what the log itself says of them."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Int, Shaped

NOTHING: Mapping[int, str] = {}
"""No cells that aren't numbers."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Waveform:
    """The clock of a channel that is sampled evenly."""

    epoch: int | None
    """Whole seconds since 1970 that `start` counts from, None where it is relative."""
    start: float
    """Time of the first sample [s]."""
    increment: float
    """Time between two samples [s]."""

    def instants(self, count: int) -> Float64[np.ndarray, " samples"]:
        """Time of each sample.

        Args:
            count: Number of samples.

        Returns:
            Their times [s], from `epoch`.
        """
        return self.start + self.increment * np.arange(count)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """Numbers of a log under one name."""

    name: str
    """Its name in the log, as a mapping gives it."""
    values: Shaped[np.ndarray, "..."]
    """Its numbers as they are written, NaN where there is none; texts of a text channel."""
    unit: str = ""
    """Its unit as the log states it, empty where it doesn't."""
    label: str = ""
    """What else the log calls it: the label of a signal in one of Simulink's structures."""
    waveform: Waveform | None = None
    """Its own clock, of a waveform."""
    epoch: int | None = None
    """Of stamps: whole seconds since 1970 that its numbers [s] count from."""
    near: tuple[int, Float64[np.ndarray, " samples"]] | None = None
    """Of numbers so large that doubles round them: a whole number, and the rest of each."""
    odd: Mapping[int, str] = dataclasses.field(default_factory=dict)
    """Cells that are no numbers, by sample."""
    lines: Int[np.ndarray, " samples"] | None = None
    """Line of the file of each sample, from 1, where there are lines."""
    missing: str = ""
    """Why its numbers can't be had, and the way out: an object that only MATLAB knows."""

    @property
    def is_number(self) -> bool:
        """Whether it holds real numbers."""
        return not self.missing and self.values.dtype.kind == "f"

    @property
    def is_text(self) -> bool:
        """Whether it holds texts."""
        return self.values.dtype.kind in "UT"

    def row(self, sample: int) -> int:
        """Where a sample stands, for a message.

        Args:
            sample: Its index.

        Returns:
            Its line where the file has lines, else its number from 1.
        """
        return sample + 1 if self.lines is None else int(self.lines[sample])


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """Everything that a file logs."""

    path: Path
    """The file."""
    channels: Mapping[str, Channel]
    """Its channels by name, in the order of the file."""
    notes: tuple[str, ...] = ()
    """How it was read, a sentence each."""
