"""A unit of a Monte Carlo of fits: a drawn robot, logged and estimated."""

from collections.abc import Callable

from experiments.runtime.parcel import Parcel, packed, unpacked
from experiments.virtual_rig.recovery import Outcome, recovered


def outcome_of(content: bytes) -> Outcome:
    """How a drawn robot's campaign went.

    Args:
        content: The unit's result.

    Returns:
        The outcome.
    """
    return Outcome(**unpacked(content).facts)


def begin(given: Parcel) -> Callable[[int, bytes], bytes]:
    """What estimates drawn robots.

    Args:
        given: The seed of the first one.

    Returns:
        From a unit's number to how its campaign went, packed.
    """
    first = given.facts["first"]
    return lambda number, payload: packed(Parcel(recovered(first + number)._asdict()))
