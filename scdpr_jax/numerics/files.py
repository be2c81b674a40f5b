"""Files that are written whole or not at all.

A fit takes minutes and may be stopped in any of them. A file that is opened and filled would
be simpler, and half of one looks like a whole to whoever reads it next. So a text goes to a
scratch file in the same folder, which takes the other's name in one step of the file system;
in another folder it might be another disk, where a move is a copy.
"""

import contextlib
import errno
import os
import pathlib
import stat
import tempfile
from collections.abc import Iterator


def regular(path: pathlib.Path) -> pathlib.Path:
    """A file that can be read to its end: a pipe waits for a writer, and a device has none.

    Args:
        path: The file.

    Returns:
        The same.

    Raises:
        OSError: If it isn't there, or isn't a file.
    """
    kind = os.stat(path).st_mode
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, "a folder, not a file", str(path))
    if not stat.S_ISREG(kind):
        raise OSError(errno.EINVAL, "a pipe or a device, which has no end", str(path))
    return pathlib.Path(path)


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
    with whole_file(path) as scratch:
        scratch.write_text(text, encoding="utf-8", newline="")


@contextlib.contextmanager
def whole_file(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A place to write a file that takes another's place in one step, if all went well.

    Args:
        path: The file, replaced if it exists; its folder is made where it is missing.

    Yields:
        An empty file beside it to be written.

    Raises:
        OSError: If the place can't be written to; what was there is still there.
    """
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-", suffix=".tmp")
    os.close(handle)
    try:
        yield pathlib.Path(name)
        # A temporary file is its owner's alone; the result is to be read like any other.
        os.chmod(name, 0o644)
        os.replace(name, path)
    except OSError as error:
        # The scratch file's name says nothing to who asked for the other one.
        if error.filename in (None, name):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        pathlib.Path(name).unlink(missing_ok=True)
