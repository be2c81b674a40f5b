"""What a process sets up before it computes units for another one."""

import functools

from experiments.runtime import set_up
from experiments.runtime.computation import compute
from experiments.runtime.installation import Installation, installation


@functools.cache
def ready() -> None:
    """Set the process up, once."""
    set_up()


def installed() -> dict[str, str]:
    """The worker's installation, for who asks it.

    Returns:
        The installation.
    """
    ready()
    return dict(installation())


def outcome(
    computation: str, shared: bytes, number: int, payload: bytes, expected: Installation
) -> bytes:
    """A unit's outcome in a worker of a cluster, see `experiments.runtime.computation.compute`.

    Args:
        computation: Name of the computation.
        shared: What its units share, packed.
        number: The unit's number.
        payload: What it is given by itself.
        expected: The installation that the result is to come from.

    Returns:
        The outcome, packed.
    """
    ready()
    return compute(computation, shared, number, payload, expected)
