"""Processes that others begin: they end with whoever began them, and by nothing before.

A terminal sends Ctrl-C to every process of a command at once. A child that heeds it ends before
the parent has said so, and the parent takes that for a fault of its work; one whose parent is
killed goes on for nobody.
"""

import contextlib
import signal
import sys
from collections.abc import Iterator

_PARENT_DEATH = 1
"""`PR_SET_PDEATHSIG` of Linux."""


def end_with_parent() -> None:
    """Let this process end when the one that began it does, and not by Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PARENT_DEATH, int(signal.SIGKILL), 0, 0, 0)


@contextlib.contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """What begins in here never hears Ctrl-C, not even while it is being loaded.

    The thread that begins it doesn't hear it meanwhile; the others of its process do.

    Yields:
        Nothing.
    """
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_pool() -> None:
    """The same for a process of a pool, whose parent's threads come and go.

    `multiprocessing` leaves the processes of a pool waiting for ever when it is killed.
    """
    import multiprocessing
    import os
    import threading

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
