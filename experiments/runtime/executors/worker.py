"""What a process sets up before it computes units for another one."""

import ctypes
import functools
import platform

from experiments.runtime import set_up
from experiments.runtime.computation import compute
from experiments.runtime.installation import Installation, installation

_TRIM, _MAP = -1, -3
"""Names of glibc's two thresholds, `M_TRIM_THRESHOLD` and `M_MMAP_THRESHOLD`."""


@functools.cache
def ready() -> None:
    """Set the process up, once."""
    set_up()
    _keep_freed_memory()


def _keep_freed_memory() -> None:
    """Let the process keep what it frees: a unit asks for as much again.

    A dask worker gives back every array, by a threshold that its nanny sets and that stops
    glibc from learning better: half of its time goes into zeroed pages then.
    """
    if platform.libc_ver()[0] == "glibc":
        library = ctypes.CDLL(None)
        library.mallopt(_MAP, 2**25)
        library.mallopt(_TRIM, 2**30)


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
