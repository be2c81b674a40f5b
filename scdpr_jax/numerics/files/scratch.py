"""What isn't to be left behind: scratch files and folders, also where a process is stopped.

Who is stopped from the keyboard in the middle of native code can't unwind: see
`experiments.verbs.ending`. So what is on its way is noted, and whoever ends the process removes
it. Steps that belong together, like the renames of an import, are taken under a lock which the
one who ends the process waits for.
"""

import contextlib
import hashlib
import os
import pathlib
import platform
import secrets
import shutil
import tempfile
import threading
from collections.abc import Iterator

TOGETHER = threading.Lock()
"""Held while what belongs together is put in its place: a process isn't ended then. Writing a
file whole takes it, so whoever holds it only renames."""
_on_the_way: set[pathlib.Path] = set()
_MARK = f"scdpr-{hashlib.sha256(platform.node().encode()).hexdigest()[:8]}"
"""Whose it is: a folder may be shared by machines, each with processes of its own."""


@contextlib.contextmanager
def scratch_folder(beside: pathlib.Path | None = None) -> Iterator[pathlib.Path]:
    """A folder that is gone afterwards, and its user's alone.

    Args:
        beside: The folder that it is made in; the system's own for such things otherwise.

    Yields:
        The folder.

    Raises:
        OSError: If it can't be made.
    """
    place = pathlib.Path(tempfile.gettempdir() if beside is None else beside)
    _remove_orphans(place)
    folder = _name(place)
    folder.mkdir(mode=0o700)
    _on_the_way.add(folder)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        _on_the_way.discard(folder)


@contextlib.contextmanager
def scratch_file(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """An empty file beside another one, that is gone afterwards if it is still there.

    What processes that were killed have left beside it is removed.

    Args:
        path: The other one.

    Yields:
        The file, with the permissions that the user's mask leaves a new file.

    Raises:
        OSError: If it can't be made.
    """
    _remove_orphans(path.parent)
    with new_scratch(path.parent) as scratch:
        os.close(os.open(scratch, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield scratch


@contextlib.contextmanager
def new_scratch(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """The name of a scratch file that isn't there yet, and is gone afterwards.

    Args:
        folder: The folder that it is for.

    Yields:
        The name.
    """
    scratch = _name(folder)
    _on_the_way.add(scratch)
    try:
        yield scratch
    finally:
        scratch.unlink(missing_ok=True)
        _on_the_way.discard(scratch)


def is_scratch(name: str | bytes | int) -> bool:
    """Whether a name is that of a scratch file.

    Args:
        name: What an error calls its file.

    Returns:
        Whether it is.
    """
    return pathlib.PurePath(os.fsdecode(name) if isinstance(name, bytes) else str(name)).match(
        f".{_MARK}-*.tmp"
    )


def note_scratch(path: pathlib.Path) -> None:
    """Note what a library leaves behind where a process doesn't end by itself.

    Args:
        path: Its file or folder.
    """
    _on_the_way.add(path)


def remove_scratch() -> None:
    """Remove what is on its way, as the process ends."""
    for path in tuple(_on_the_way):
        _remove(path)


def _name(folder: pathlib.Path) -> pathlib.Path:
    """A name that nothing has, and that says whose it is."""
    return folder / f".{_MARK}-{os.getpid()}-{secrets.token_hex(6)}.tmp"


def _remove(path: pathlib.Path) -> None:
    with contextlib.suppress(OSError):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _remove_orphans(folder: pathlib.Path) -> None:
    """Remove what processes that were killed have left on this machine."""
    for left in folder.glob(f".{_MARK}-*.tmp"):
        owner = left.name.split("-")[2]
        if owner.isdecimal() and not _is_running(int(owner)):
            _remove(left)


def _is_running(process: int) -> bool:
    if os.name == "nt":  # where asking a process is ending it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
