"""Files that are written whole or not at all.

A fit takes minutes and may be stopped in any of them. A file that is opened and filled would
be simpler, and half of one looks like a whole to whoever reads it next. So a text goes to a
file that has no name yet, on the same disk, and takes the other's name in one step once all of
it has reached the disk: a process that is ended at once leaves nothing. Where a system knows no
such file, or its writer goes by a name, it is a scratch file beside the other.
"""

import contextlib
import errno
import os
import pathlib
from collections.abc import Iterator

from scdpr_jax.numerics.files.scratch import TOGETHER, is_scratch, new_scratch, scratch_file

_HANDLES = "/proc/self/fd"
"""Where Linux has the files that this process has open, those without a name as well."""


def write_whole(path: pathlib.Path, text: str) -> None:
    """Put a text where a file was or will be, in one step.

    Whoever reads the file at any moment finds the old text or the new one. A folder that
    is missing is made.

    Args:
        path: The file, replaced if it exists.
        text: What it shall hold; written as UTF-8 with the line ends that it has. A lone
            surrogate, of a name that isn't UTF-8, is written out.

    Raises:
        OSError: If the place can't be written to; what was there is still there.
    """
    write_bytes_whole(path, text.encode("utf-8", "backslashreplace"))


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

    Args:
        path: The file, replaced if it exists; its folder is made where it is missing.
        named_in: A folder on the same disk in which the place is to have a name: for writers
            that can't do without. None for those that can.

    Yields:
        An empty file to be written.

    Raises:
        OSError: If the place can't be written to; what was there is still there. It names the
            file, and no scratch file.
    """
    path = pathlib.Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        place = _named(path, named_in) if named_in else _anywhere(path)
        with place as scratch:
            yield scratch
    except OSError as error:
        name = error.filename
        if name is not None and not is_scratch(name) and not str(name).startswith(_HANDLES):
            raise
        code, reason = error.errno or errno.EIO, error.strerror or str(error)
        raise OSError(code, reason, str(path)) from error


def settle(folder: pathlib.Path) -> None:
    """Wait until the names in a folder have reached the disk, before what they replace goes.

    Args:
        folder: The folder.
    """
    if os.name != "nt":  # There a folder can't be opened.
        _to_disk(folder, os.O_RDONLY)


@contextlib.contextmanager
def _named(path: pathlib.Path, folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """A scratch file that takes the other's place."""
    with scratch_file(folder / path.name) as scratch:
        yield scratch
        _to_disk(scratch, os.O_RDWR)
        with TOGETHER:
            os.replace(scratch, path)


@contextlib.contextmanager
def _anywhere(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A file without a name where there is such a thing, else a scratch file beside it."""
    handle = _nameless(path.parent)
    if handle is None:
        with _named(path, path.parent) as scratch:
            yield scratch
        return
    try:
        yield pathlib.Path(_HANDLES, str(handle))
        os.fsync(handle)
        with TOGETHER:
            _take_name(handle, path)
    finally:
        os.close(handle)


def _nameless(folder: pathlib.Path) -> int | None:
    """An open file without a name; None where the system or the disk knows no such thing."""
    kind = getattr(os, "O_TMPFILE", None)
    if kind is None or not os.path.isdir(_HANDLES):
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
        with new_scratch(path.parent) as scratch:
            _link(handle, scratch)
            os.replace(scratch, path)


def _link(handle: int, path: pathlib.Path) -> None:
    # With a folder's handle Python follows the link to the file itself, without it doesn't.
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.link(f"{_HANDLES}/{handle}", path.name, src_dir_fd=folder, dst_dir_fd=folder)
    finally:
        os.close(folder)


def _to_disk(path: pathlib.Path, how: int) -> None:
    """A name that outlives a power cut must not be that of a file which doesn't."""
    handle = os.open(path, how)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
