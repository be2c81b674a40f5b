"""The catalogue: every shaper of one mode, by name."""

from collections.abc import Callable
from typing import Any, NamedTuple

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.catalogue.extra_insensitive import ei, three_hump_ei, two_hump_ei
from tuning.shapers.catalogue.unity_magnitude import um_ei, um_zv
from tuning.shapers.catalogue.zero_vibration import mzv, zv, zvd, zvdd


class Entry(NamedTuple):
    """A shaper of the catalogue."""

    name: str
    """Name in `shaper.json` and on the command line."""
    design: Callable[[Any, Any], Shaper]
    """From frequency [Hz] and damping ratio [1] to the shaper."""
    periods: float
    """Duration from the first to the last impulse without damping, in periods."""
    meaning: str
    """What it does, for a table."""


CATALOGUE: tuple[Entry, ...] = (
    Entry("zv", zv, 0.5, "zero vibration at the nominal frequency"),
    Entry("mzv", mzv, 0.75, "zero vibration by three impulses 3/8 of a period apart"),
    Entry("zvd", zvd, 1.0, "zero vibration, flat around the nominal frequency"),
    Entry("ei", ei, 1.0, "5 % at the nominal frequency, zero on both sides"),
    Entry("zvdd", zvdd, 1.5, "zero vibration, flatter around the nominal frequency"),
    Entry("2hump_ei", two_hump_ei, 1.5, "zero at the nominal frequency between humps of 5 %"),
    Entry("3hump_ei", three_hump_ei, 2.0, "humps of 5 % at and beside the nominal frequency"),
)
"""The shapers of positive impulses, the shortest first."""

UNITY_MAGNITUDE: tuple[Entry, ...] = (
    Entry("um_zv", um_zv, 1 / 3, "zero vibration by impulses of 1 and -1"),
    Entry("um_ei", um_ei, 0.7367, "5 % at the nominal frequency by impulses of 1 and -1"),
)
"""The shapers of impulses of 1 and -1: shorter, and harder on the drive."""
