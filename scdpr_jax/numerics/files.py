"""Files that are written whole or not at all.

A fit takes minutes and may be stopped in any of them. A file that is opened and filled would
be simpler, and half of one looks like a whole to whoever reads it next. So a text goes to a
file that has no name yet, on the same disk, and takes the other's name in one step once all of
it has reached the disk. Where a file must have a name it has one of its own beside the other;
a process that is ended at once leaves that behind.
"""

import contextlib
import os
import pathlib
import secrets
from collections.abc import Iterator


def write_whole(path: pathlib.Path, text: str) -> None:
    """Put a text where a file was or will be, in one step.

    Whoever reads the file at any moment finds the old text or the new one. A folder that
    is missing is made.

    Args:
        path: The file, replaced if it exists.
        text: What it shall hold; written as UTF-8 with the line ends that it has.

    Raises:
        OSError: If the place can't be written to; what was there is still there.
    """
    write_bytes_whole(path, text.encode("utf-8"))


def write_bytes_whole(path: pathlib.Path, content: bytes) -> None:
    """Put bytes where a file was or will be, in one step, as `write_whole` does a text.

    Args:
        path: The file, replaced if it exists.
        content: What it shall hold.

    Raises:
        OSError: If the place can't be written to; what was there is still there.
    """
    with whole_file(path) as scratch:
        scratch.write_bytes(content)


@contextlib.contextmanager
def whole_file(
    path: pathlib.Path, *, named_in: pathlib.Path | None = None
) -> Iterator[pathlib.Path]:
    """A place to write a file that takes another's place in one step, if all went well.

    The file is the user's as the user's mask of permissions has it.

    Args:
        path: The file, replaced if it exists; its folder is made where it is missing.
        named_in: Where the place is to be, with a name that ends as the file's does, on the
            same disk: for writers that go by a name. None for those that don't.

    Yields:
        An empty file on the same disk to be written.

    Raises:
        OSError: If the place can't be written to; what was there is still there.
    """
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = None if named_in else _nameless(path.parent)
    if handle is None:
        with _named((named_in or path.parent) / path.name) as (handle, scratch):
            yield scratch
            os.fsync(handle)
            os.replace(scratch, path)
        return
    try:
        scratch = pathlib.Path(f"/proc/self/fd/{handle}")
        yield scratch
        os.fsync(handle)
        _take_name(handle, path)
    finally:
        os.close(handle)


def settle(folder: pathlib.Path) -> None:
    """Wait until the names in a folder have reached the disk, before what they replace goes.

    Args:
        folder: The folder.
    """
    if os.name == "nt":  # A folder can't be opened there.
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _nameless(folder: pathlib.Path) -> int | None:
    """An open file without a name; None where the system or the disk knows no such thing."""
    kind = getattr(os, "O_TMPFILE", None)
    if kind is None or not os.path.isdir("/proc/self/fd"):
        return None
    try:
        return os.open(folder, kind | os.O_RDWR, 0o666)
    except OSError:
        # Whatever else is wrong with the place is said by the file with a name.
        return None


def _take_name(handle: int, path: pathlib.Path) -> None:
    """Give a file without a name the name of another one, or of none."""
    try:
        _link(handle, path)
    except FileExistsError:
        # A link replaces nothing, a file with a name does.
        scratch = _scratch(path)
        _link(handle, scratch)
        try:
            os.replace(scratch, path)
        finally:
            scratch.unlink(missing_ok=True)


def _link(handle: int, path: pathlib.Path) -> None:
    # With a folder's handle Python follows the link to the file itself, without it doesn't.
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.link(f"/proc/self/fd/{handle}", path.name, src_dir_fd=folder, dst_dir_fd=folder)
    finally:
        os.close(folder)


@contextlib.contextmanager
def _named(path: pathlib.Path) -> Iterator[tuple[int, pathlib.Path]]:
    """A new file beside another, open, which goes if it still has its name in the end."""
    scratch = _scratch(path)
    handle = os.open(scratch, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666)
    try:
        yield handle, scratch
    finally:
        os.close(handle)
        scratch.unlink(missing_ok=True)


def _scratch(path: pathlib.Path) -> pathlib.Path:
    # A name of its own, not a longer one: 255 bytes are a name's limit.
    return path.with_name(f".{secrets.token_hex(8)}.tmp{path.suffix[:16]}")
