"""Computations that divide into units, by name, and a unit of one computed.

A worker is told a name and given data. What the name stands for it imports from its own
installed package, so that no program comes over the wire.
"""

import functools
import importlib
import json
from collections.abc import Callable, Mapping
from typing import NamedTuple

from experiments.runtime.installation import Installation, different, installation
from experiments.runtime.parcel import Parcel, unpacked

Compute = Callable[[int, bytes], bytes]
"""From a unit's number and what it is given to its result."""
Begin = Callable[[Parcel], Compute]
"""From what all units of a computation share to what computes one."""

COMPUTATIONS: Mapping[str, str] = {
    "sweep": "experiments.sweep.unit",
    "identify": "experiments.studies.campaigns.unit",
    "legs": "experiments.studies.legs.unit",
    "codesign": "experiments.studies.codesign.unit",
    "recovery": "experiments.virtual_rig.unit",
}
"""Every computation that divides, and the module whose `begin` begins it."""

FAILURES = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)
"""What a unit may fail with, so that the others go on; stopping the process isn't among it."""


class Outcome(NamedTuple):
    """What became of a unit."""

    content: bytes
    """Its result; empty for none."""
    failure: str = ""
    """Why there is none; empty if there is one."""
    foreign: str = ""
    """How the installation of whoever was to compute it differs; empty if it doesn't."""

    def packed(self) -> bytes:
        """The outcome as bytes."""
        head = json.dumps([self.failure, self.foreign]).encode()
        return len(head).to_bytes(4, "big") + head + self.content

    @classmethod
    def unpacked(cls, content: bytes) -> "Outcome":
        """An outcome from its bytes."""
        end = 4 + int.from_bytes(content[:4], "big")
        return cls(content[end:], *json.loads(content[4:end]))


def compute(
    computation: str, shared: bytes, number: int, payload: bytes, expected: Installation
) -> bytes:
    """A unit's outcome, in whatever process this is.

    Args:
        computation: Name of the computation.
        shared: What its units share, packed.
        number: The unit's number.
        payload: What it is given by itself.
        expected: The installation that the result is to come from.

    Returns:
        The outcome, packed.
    """
    if foreign := different(installation(), dict(expected)):
        return Outcome(b"", foreign=foreign).packed()
    try:
        return Outcome(_begun(computation, shared)(number, payload)).packed()
    except FAILURES as error:
        return Outcome(b"", f"{type(error).__name__}: {error}").packed()


@functools.lru_cache(maxsize=4)
def _begun(computation: str, shared: bytes) -> Compute:
    begin: Begin = importlib.import_module(COMPUTATIONS[computation]).begin
    return begin(unpacked(shared))
