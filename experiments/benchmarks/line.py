"""One line of a benchmark's table."""

from typing import NamedTuple


class Settings(NamedTuple):
    """How thoroughly to measure."""

    repeats: int
    """Times that a median is of."""
    largest_batch: int
    """Largest batch of runs."""


class Line(NamedTuple):
    """What was measured of one contender on one task."""

    row: str
    """The task."""
    contender: str
    """Who."""
    batch: int
    """How many at once."""
    median: float | None = None
    """Median time [s]; None where it wasn't run."""
    rate: float | None = None
    """How much is done in a second [`unit` per second]."""
    unit: str = ""
    """What is counted: "robot-s", "Jacobian", "fit", "frequency"."""
    compile: float | None = None
    """Time of compilation [s]."""
    ratio: str = ""
    """How it stands to another one in the same turns."""
    error: str = ""
    """Error against exact friction, with its unit."""
    note: str = ""
    """What else is to be known; why it wasn't run."""
