"""A folder for one process at a time, until that one ends in whatever way."""

import contextlib
import os
import pathlib
import sys
from collections.abc import Iterator

LOCK = "lock"
"""Name of the file that is locked."""


@contextlib.contextmanager
def locked(folder: pathlib.Path) -> Iterator[None]:
    """Have a folder to oneself; it is made where it is missing.

    The system takes the lock back from a process that is killed.

    Args:
        folder: The folder.

    Yields:
        Nothing, while no other process has it.

    Raises:
        BlockingIOError: If another process has it.
        OSError: If the place can't be written to.
    """
    while True:
        handle = _opened(folder)
        try:
            _lock(handle)
        except BlockingIOError:
            os.close(handle)
            raise
        # Who had it before may have removed it since it was opened.
        if _is(handle, folder / LOCK):
            break
        os.close(handle)
    try:
        yield
    finally:
        os.close(handle)


def _opened(folder: pathlib.Path) -> int:
    while True:
        folder.mkdir(parents=True, exist_ok=True)
        # Who had it before may remove the folder between the two.
        with contextlib.suppress(FileNotFoundError):
            return os.open(folder / LOCK, os.O_CREAT | os.O_RDWR, 0o666)


def _is(handle: int, path: pathlib.Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def _lock(handle: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError(*error.args) from None
        return
    import fcntl

    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
