"""A tuning tried beforehand by a process of its own, so that all it needs is compiled.

What a first tuning takes is tracing, reading equations and compiling, most of it in Python:
threads that prepared it while a fit compiles what it needs would wait for each other. Another
process doesn't, and what it makes is kept on disk, where the tuning finds it.
"""

import contextlib
import multiprocessing
import os
from collections.abc import Callable, Iterator

from experiments.runtime import set_up
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import lasting_name
from scdpr_jax.numerics.processes import deaf_to_interrupts, end_with_pool
from scdpr_jax.robot.prototype import consistent
from tuning.gains.manoeuvre import LEG_TIMES
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune

_LITTLE = Effort(legs=2, generations=1, planned=2)
"""Enough to run everything once, with as many designs a generation as ever."""


@contextlib.contextmanager
def rehearsed(leg_times: tuple[float, ...] = LEG_TIMES) -> Iterator[Callable[[], None]]:
    """A tuning's rehearsal beside whatever else there is to do, unless there was one before.

    This is for the command line: the process would run a program anew that isn't guarded by
    `if __name__ == "__main__"`.

    Args:
        leg_times: Times of a leg that the tuning will be asked for [s].

    Yields:
        What waits until the rehearsal is over. One that fails says nothing: the tuning itself
        will.
    """
    name = lasting_name("rehearsal", [tune], repr(leg_times))
    if not name or store.folder() is None or store.kept(name) is not None:
        yield lambda: None
        return
    context = multiprocessing.get_context("spawn")
    process = context.Process(target=_rehearse, args=(name, leg_times), daemon=True)
    with deaf_to_interrupts():
        process.start()
    try:
        yield process.join
    finally:
        process.kill()
        process.join()


def _rehearse(name: str, leg_times: tuple[float, ...]) -> None:
    """A tuning of the prototype, after which nobody rehearses it again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    end_with_pool()
    set_up()
    tune(FittedRobot(consistent(), (), None), None, leg_times=leg_times, effort=_LITTLE)
    store.keep(name, b"")
