"""A long computation, described: what it is, what all units share, what each is given."""

import dataclasses
import functools
import hashlib
from collections.abc import Callable

from experiments.runtime.installation import Installation
from experiments.runtime.parcel import Parcel, packed


def nothing(number: int) -> bytes:
    """What a unit is given that its number says everything to.

    Args:
        number: Its number.

    Returns:
        Nothing.
    """
    return b""


@dataclasses.dataclass(frozen=True)
class Job:
    """Independent units of one computation, numbered from 0."""

    computation: str
    """Its name in `experiments.runtime.computation.COMPUTATIONS`."""
    context: Parcel
    """What all its units share."""
    count: int
    """Number of units."""
    installation: Installation
    """Of whoever computes them."""
    payload: Callable[[int], bytes] = nothing
    """What a unit is given by itself, looked up when it is its turn."""

    @functools.cached_property
    def shared(self) -> bytes:
        """What all units share, packed."""
        return packed(self.context)

    @functools.cached_property
    def key(self) -> bytes:
        """A hash of everything that the results depend on, but what single units are given."""
        facts = {"computation": self.computation, "count": self.count}
        about = packed(Parcel({**facts, "installation": dict(self.installation)}))
        return hashlib.sha256(hashlib.sha256(about).digest() + self.shared).digest()

    def identity(self, number: int, payload: bytes) -> bytes:
        """A hash of everything that a unit's result depends on.

        Args:
            number: The unit's number.
            payload: What it is given by itself.

        Returns:
            The hash.
        """
        own = number.to_bytes(8, "big") + hashlib.sha256(payload).digest()
        return hashlib.sha256(self.key + own).digest()
