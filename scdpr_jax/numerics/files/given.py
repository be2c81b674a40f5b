"""A file that somebody gives: looked at before it is opened, and read within a limit.

A name says nothing of what stands behind it. A pipe waits for ever, a device has no end, and a
file of gigabytes takes the memory of everything else. So a file is opened only where it is a
file and of a size that was agreed on; `path.read_bytes()` would be simpler, and finds out late.
"""

import csv
import io
import os
import pathlib
import stat

from scdpr_jax.numerics.files.harmless import shortened

MEBIBYTE = 2**20
"""Unit of the limits [bytes]."""
DOCUMENT = MEBIBYTE
"""Largest document in TOML [bytes]: a mapping of a thousand runs is half of it."""
RESULT = 8 * MEBIBYTE
"""Largest file of results in JSON [bytes]: values of it take twenty times their text."""
TABLE = 64 * MEBIBYTE
"""Largest table of numbers in text [bytes]: twenty minutes of a drive at 1 kHz."""
SHORT_TABLE = 8 * MEBIBYTE
"""Largest table that is there as texts before it is understood [bytes], sixty times as long: a
plan of a minute, a hundred thousand legs or frequencies of a spectrum."""
TEXT_LOG = 128 * MEBIBYTE
"""Largest log of another program in text [bytes]: half an hour of eight channels at 1 kHz."""
LOG = 256 * MEBIBYTE
"""Largest log of another program in numbers as they are in memory [bytes]: TDMS and MAT."""
CELL = 10_000
"""Longest cell of a table [characters]."""


class FileError(ValueError):
    """A file that isn't read, with what it is instead and the way out."""

    def __init__(self, path: object, what: str, *, got: str, expected: str, remedy: str):
        self.path = path
        """The file."""
        self.what = what
        """What is wrong with it."""
        self.got = got
        """What was found."""
        self.expected = expected
        """What was expected."""
        self.remedy = remedy
        """What to do."""
        super().__init__(f"{path}: {what}, got {got}, expected {expected}. {remedy}")


def read_given(path: pathlib.Path, *, most: int) -> bytes:
    """A file's content.

    Args:
        path: The file.
        most: Its largest size [bytes].

    Returns:
        What stands in it.

    Raises:
        FileError: If it is no file, or larger.
        OSError: If there is none, or it can't be opened.
    """
    require_file(path, most=most)
    # Whatever has come into its place since isn't waited for.
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with open(os.open(path, flags), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise _no_file(path, os.fstat(file.fileno()).st_mode)
        content = file.read(most + 1)
    if len(content) > most:
        raise _too_large(path, len(content), most)
    return content


def require_file(path: pathlib.Path, *, most: int) -> None:
    """Refuse what is no file, or too large a one, before it is opened.

    Args:
        path: The file.
        most: Its largest size [bytes].

    Raises:
        FileError: If it is a folder, a pipe, a socket or a device, or larger.
        OSError: If there is none.
    """
    try:
        about = os.stat(path)
    except ValueError:  # a zero byte in the name
        raise FileError(
            path,
            "no name of a file",
            got="a name with a zero byte",
            expected="a file",
            remedy="Correct the name.",
        ) from None
    if not stat.S_ISREG(about.st_mode):
        raise _no_file(path, about.st_mode)
    if about.st_size > most:
        raise _too_large(path, about.st_size, most)


def read_given_text(path: pathlib.Path, *, most: int) -> str:
    """A file's text in UTF-8, without a byte order mark.

    Args:
        path: The file.
        most: Its largest size [bytes].

    Returns:
        Its text.

    Raises:
        FileError: If it is no file, larger, or no such text.
        OSError: If there is none, or it can't be opened.
    """
    content = read_given(path, most=most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        raise FileError(
            path,
            "not text in UTF-8",
            got=f"the byte 0x{content[error.start]:02x} in row {row}",
            expected="a text file in UTF-8",
            remedy="Save it as plain text (UTF-8).",
        ) from None


def read_given_rows(path: pathlib.Path) -> list[tuple[int, list[str]]]:
    """The rows of a table between commas.

    Args:
        path: The file, a `SHORT_TABLE`.

    Returns:
        Each row that isn't empty, with its line from 1.

    Raises:
        FileError: If it is no file, larger, no text in UTF-8, or can't be split into cells.
        OSError: If there is none, or it can't be opened.
    """
    return split_rows(path, read_given_text(path, most=SHORT_TABLE))


def split_rows(path: pathlib.Path, text: str) -> list[tuple[int, list[str]]]:
    """The rows of a text between commas.

    Args:
        path: The file that it stands in.
        text: The text.

    Returns:
        Each row that isn't empty, with its line from 1.

    Raises:
        FileError: If it can't be split into cells.
    """
    reader = csv.reader(io.StringIO(text, newline=""))
    rows = []
    try:
        for row in reader:
            if any(len(cell) > CELL for cell in row):
                raise _broken(path, reader.line_num, f"a cell longer than {CELL} characters")
            if any(row):
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise _broken(path, reader.line_num, str(error)) from None
    return rows


def _broken(path: pathlib.Path, row: int, got: str) -> FileError:
    return FileError(
        path,
        f"row {row} can't be split into cells",
        got=shortened(got),
        expected="cells between commas",
        remedy="Look for a lone quotation mark, or a damaged part of the file.",
    )


def _no_file(path: pathlib.Path, mode: int) -> FileError:
    kinds = {
        stat.S_IFDIR: "a folder",
        stat.S_IFIFO: "a pipe",
        stat.S_IFSOCK: "a socket",
        stat.S_IFCHR: "a device",
        stat.S_IFBLK: "a device",
    }
    return FileError(
        path,
        "the file can't be read",
        got=kinds.get(stat.S_IFMT(mode), "something else"),
        expected="a file",
        remedy="Name the file itself; what comes through a pipe is to be saved first.",
    )


def _too_large(path: pathlib.Path, size: int, most: int) -> FileError:
    return FileError(
        path,
        "the file is too large",
        got=f"{size / MEBIBYTE:,.1f} MiB or more",
        expected=f"{most / MEBIBYTE:g} MiB at most",
        remedy="Is it the right one? A longer log is cut into several.",
    )
