"""A tuning tried beforehand by another process, so that all it needs is compiled.

What a first tuning takes is tracing, reading equations and compiling, most of it in Python:
threads that prepared it while a fit compiles what it needs would wait for each other. Another
process doesn't, and what it makes is kept on disk, where the tuning finds it.
"""

import concurrent.futures
import contextlib
import os
import sys
from collections.abc import Iterator

from identification.result.fitted_robot import FittedRobot
from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import lasting_name
from scdpr_jax.robot.prototype import consistent
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune

_LITTLE = Effort(legs=2, generations=1, planned=2)
"""Enough to run everything once, with as many designs a generation as ever."""


def rehearse(
    processes: concurrent.futures.Executor | None, leg_times: tuple[float, ...]
) -> list[concurrent.futures.Future[None]]:
    """Has a tuning rehearsed beside whatever else there is to do, if it never was.

    Args:
        processes: Who rehearses; None for nobody.
        leg_times: Times of a leg that the tuning will be asked for [s].

    Returns:
        What to wait for, nothing or one. A rehearsal that fails says nothing: the tuning
        itself will.
    """
    name = lasting_name("rehearsal", [tune], repr(leg_times))
    known = not name or store.folder() is None or store.kept(name) is not None
    return [] if known or processes is None else [processes.submit(_rehearse, name, leg_times)]


def _rehearse(name: str, leg_times: tuple[float, ...]) -> None:
    """A tuning, after which nobody rehearses it again."""
    with _unheard():
        _tuned(leg_times)
    store.keep(name, b"")


def _tuned(leg_times: tuple[float, ...]) -> None:
    prototype = FittedRobot(consistent(), (), None)
    tune(prototype, None, leg_times=leg_times, effort=_LITTLE)


@contextlib.contextmanager
def _unheard() -> Iterator[None]:
    """What is said meanwhile, by libraries as well, is said to nobody."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    streams = [(stream, os.dup(stream)) for stream in (1, 2)]
    try:
        for stream, _ in streams:
            os.dup2(nowhere, stream)
        yield
    finally:
        for text in (sys.stdout, sys.stderr):
            text.flush()
        for stream, before in streams:
            os.dup2(before, stream)
            os.close(before)
        os.close(nowhere)
