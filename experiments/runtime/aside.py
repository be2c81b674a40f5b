"""Processes beside the command line's own: they draw, plan and rehearse while it computes.

All of that is Python for the most part, and threads would wait for each other. What a process
has to load takes two seconds, so where the system lets processes fork one of them loads it, and
is copied.
"""

import atexit
import concurrent.futures
import contextlib
import gc
import io
import multiprocessing.forkserver
import multiprocessing.resource_tracker
import multiprocessing.util
import os
import pathlib
from collections.abc import Iterator, Mapping
from multiprocessing.context import BaseContext

from experiments.runtime.entry_point import set_up
from scdpr_jax.numerics.files.scratch import note_scratch
from scdpr_jax.numerics.processes import deaf_to_interrupts, end_with_pool

_LOADED = ("experiments.reports.report", "experiments.studies.pipeline")
"""What has all that is asked of them."""


@contextlib.contextmanager
def processes_aside(
    number: int = os.cpu_count() or 1,
) -> Iterator[concurrent.futures.ProcessPoolExecutor]:
    """Processes that know what the command line knows, for as long as there is need of them.

    A program that isn't guarded by `if __name__ == "__main__"` would be run anew by each, so
    this is for the command line.

    Args:
        number: How many. What they need begins to load at once, while the caller goes on.

    Yields:
        The pool. What it is still doing at the end is for nobody, and is dropped.
    """
    context = _loading()
    pool = concurrent.futures.ProcessPoolExecutor(
        number,
        mp_context=context,
        initializer=_begin,
        initargs=(dict(os.environ), gc.get_threshold()),
    )
    before = multiprocessing.active_children()
    try:
        if context.get_start_method() == "spawn":
            with deaf_to_interrupts():
                for _ in range(number):
                    pool.submit(int)  # Nothing, but a process begins for it.
        yield pool
    finally:
        for process in multiprocessing.active_children():
            if process not in before:
                process.kill()
                process.join()
        pool.shutdown(cancel_futures=True)


def _loading() -> BaseContext:
    """How processes begin: as forks of one that begins to load, or each by itself."""
    if "forkserver" in multiprocessing.get_all_start_methods():
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([*_LOADED])
        # Whoever begins it unblocks Ctrl-C, so it has to be there before.
        multiprocessing.resource_tracker.ensure_running()
        # Its socket's name may be longer than sockets' are, as a folder's may be.
        with contextlib.suppress(OSError), deaf_to_interrupts():
            note_scratch(pathlib.Path(multiprocessing.util.get_temp_dir()))
            multiprocessing.forkserver.ensure_running()
            return context
    return multiprocessing.get_context("spawn")


def _begin(environment: Mapping[str, str], threshold: tuple[int, ...]) -> None:
    """A process that computes as the one does that began it, and is ended by it."""
    end_with_pool()
    os.environ.update(environment)  # What it was copied from may be of an earlier one.
    with contextlib.redirect_stderr(io.StringIO()):  # Whoever began it has said so.
        set_up()
    gc.set_threshold(*threshold)
    atexit.register(os._exit, 0)  # Taking libraries apart at the end serves nobody.
