"""How a command is ended from outside: one line, the right status, nothing left behind.

Python runs the handler of a signal in its main thread, between two of its own steps. Where that
thread compiles or computes, it does so minutes later; where it is in the middle of cleaning up,
the exception goes nowhere; and a process that unwinds while threads still compute may crash. So
a thread of its own waits for the signal, removes what is on its way and ends the process. Files
are put in their places whole, and what belongs together under a lock that it waits for.
"""

import os
import signal
import socket
import sys
import threading
from typing import NoReturn

from experiments.verbs.exit_status import BAD_INPUT, UNHEARD

# Here, and not where it is used: two threads that import the same in other orders lock each
# other out.
from scdpr_jax.numerics.files.scratch import TOGETHER, remove_scratch

_WORDS = {"SIGINT": "stopped", "SIGTERM": "terminated", "SIGHUP": "its terminal is gone"}
_GOES_ON = dict.fromkeys(("sweep", "identify"), " The same call goes on from here.")
"""What verbs that keep what they have computed add."""
_PATIENCE = 0.7
"""Time that renames which belong together may take [s]."""


def end_on_signals(verb: str) -> None:
    """End this process within a second of Ctrl-C, a kill or a hang-up, whatever it is doing.

    Args:
        verb: The verb that it runs, for the line that it ends with.
    """
    # Who keeps the books of a pool's semaphores would complain that they are left.
    known = os.environ.get("PYTHONWARNINGS")
    quiet = "ignore::UserWarning:multiprocessing.resource_tracker"
    os.environ["PYTHONWARNINGS"] = f"{known},{quiet}" if known else quiet
    waiting, woken = socket.socketpair()
    woken.setblocking(False)
    signal.set_wakeup_fd(woken.detach(), warn_on_full_buffer=False)
    for name in _WORDS:
        number = getattr(signal, name, None)
        # Who was begun with `nohup`, or behind `&`, stays deaf.
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hold_still)
    watcher = threading.Thread(target=_watch, args=(verb, waiting), daemon=True)
    watcher.start()


def leave(status: int) -> NoReturn:
    """End this process as it is: everything is written and said.

    Python would wait for threads that still compute, and hear no more signals while it does.

    Args:
        status: Its exit status.
    """
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except BrokenPipeError:
        status = UNHEARD
    except OSError as error:
        _say(f"scdpr: the output can't be written, got {error.strerror}. Make room for it.")
        status = BAD_INPUT
    remove_scratch()
    os._exit(status)


def _hold_still(number: int, frame: object) -> None:
    """The main thread says nothing more, but for what it has to finish."""
    if not TOGETHER.locked():
        threading.Event().wait(2 * _PATIENCE)


def _watch(verb: str, waiting: socket.socket) -> None:
    handled = {getattr(signal, name, None): word for name, word in _WORDS.items()}
    while (number := waiting.recv(1)[0]) not in handled:
        pass  # of somebody else's handler
    try:
        TOGETHER.acquire(timeout=_PATIENCE)
        _say(
            f"scdpr {verb}: {handled[number]}.{_GOES_ON.get(verb, ' No file is half written.')}"
        )
        remove_scratch()
        _end_pools()
    finally:
        os._exit(128 + number)


def _say(line: str) -> None:
    """The last line, past whatever a progress bar is drawing."""
    clear = "\r\x1b[2K\x1b[?25h" if sys.stderr is not None and sys.stderr.isatty() else ""
    try:
        os.write(2, f"{clear}{line}\n".encode())
    except OSError:
        return  # nobody listens any more


def _end_pools() -> None:
    """End the processes of pools, which would wait for more work."""
    # An import would wait for the main thread, where that one is just importing it.
    active_children = getattr(sys.modules.get("multiprocessing"), "active_children", tuple)
    for child in active_children():
        child.kill()
