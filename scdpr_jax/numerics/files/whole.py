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
from collections.abc import Iterator

from scdpr_jax.numerics.files.scratch import TOGETHER, is_scratch, scratch_file


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
    with whole_file(path) as scratch:
        scratch.write_bytes(text.encode("utf-8", "backslashreplace"))


@contextlib.contextmanager
def whole_file(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A place to write a file that takes another's place in one step, if all went well.

    Args:
        path: The file, replaced if it exists; its folder is made where it is missing.

    Yields:
        An empty file beside it to be written.

    Raises:
        OSError: If the place can't be written to; what was there is still there. It names the
            file, and no scratch file.
    """
    path = pathlib.Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with scratch_file(path) as scratch:
            yield scratch
            _to_disk(scratch)
            with TOGETHER:
                os.replace(scratch, path)
    except OSError as error:
        if error.filename is not None and not is_scratch(error.filename):
            raise
        code, reason = error.errno or errno.EIO, error.strerror or str(error)
        raise OSError(code, reason, str(path)) from error


def _to_disk(path: pathlib.Path) -> None:
    """A name that outlives a power cut must not be that of a file which doesn't."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
