"""The text of a file in whatever encoding it was written, a piece at a time.

A log of 128 MiB would take four times that as one text, and sixteen as cells: lines are decoded
whenever they are gone through.
"""

import codecs
import dataclasses
from collections.abc import Iterator
from pathlib import Path

from identification.campaign.faults import Fault
from scdpr_jax.numerics.files.given import TEXT_LOG, read_given

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
"""Marks at a file's begin that say its encoding; the longer ones first."""
_HEAD = 4096
"""Bytes that tell whether a file is text [bytes]."""
_BINARY = {
    b"PK\x03\x04": "a spreadsheet's workbook or another archive",
    b"\x1f\x8b": "a compressed file",
    b"%PDF": "a PDF",
    b"TDSh": "the index of a TDMS file",
    b"\xd0\xcf\x11\xe0": "a spreadsheet's old workbook",
    b"RIFF": "a video or a sound",
    b"PAR1": "a Parquet table",
}
"""What begins with some bytes and is no log that is read here."""


_PIECE = 2**20
"""Bytes that are decoded at a time."""
_LONGEST = 2**20
"""Longest line of a log [characters]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Text:
    """A text that is decoded as it is gone through."""

    content: bytes
    """Its bytes."""
    encoding: str
    """How they are to be decoded."""
    errors: str = "strict"
    """What becomes of bytes that are no text: see `codecs`."""

    def pieces(self) -> Iterator[str]:
        """The text, piece by piece, without a byte order mark.

        Yields:
            The pieces.

        Raises:
            UnicodeDecodeError: If it isn't written so; its place counts from the file's begin.
        """
        decoder = codecs.getincrementaldecoder(self.encoding)(self.errors)
        for begin in range(0, max(len(self.content), 1), _PIECE):
            end = begin + _PIECE
            waiting = len(decoder.getstate()[0])
            try:
                piece = decoder.decode(self.content[begin:end], end >= len(self.content))
            except UnicodeDecodeError as error:
                error.start += begin - waiting
                raise
            yield piece if begin else piece.removeprefix("\ufeff")

    def lines(self) -> Iterator[tuple[int, str]]:
        """Its lines, each with its number from 1."""
        number, rest = 1, ""
        for piece in self.pieces():
            # The last line may go on, and what ends it may have a second half.
            *whole, rest = (rest + piece).splitlines(keepends=True) or [""]
            for line in whole:
                yield number, line.rstrip(_ENDS)
                number += 1
        if rest:
            yield number, rest.rstrip(_ENDS)

    @property
    def begin(self) -> str:
        """Its first piece."""
        return next(self.pieces(), "")


_ENDS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"
"""What ends a line."""


def read_text(path: Path, encoding: str | None) -> tuple[Text, str, Fault | None]:
    """A file's text.

    Args:
        path: The file.
        encoding: Its encoding, None to find it.

    Returns:
        The text; how it was found to be written, empty where it is UTF-8 or as stated; the
        fault where there is no text.
    """
    content = read_given(path, most=TEXT_LOG)
    nothing, head = Text(b"", "utf-8"), content[:_HEAD]
    if not head.strip(b"\0"):
        return nothing, "", _no_text(path, "nothing" if not head else "zero bytes")
    for begin, what in _BINARY.items():
        if head.startswith(begin):
            return nothing, "", _no_text(path, what)
    name, note = _encoding(head) if encoding is None else (encoding, "")
    if name is None:
        return nothing, "", _no_text(path, "bytes that are no text")
    if not _is_known(name):
        return nothing, "", _no_encoding(path, name)
    text = Text(content, name)
    try:
        fault = _fault(path, text)
    except UnicodeError as error:
        if encoding is not None or name != "utf-8":
            return nothing, "", _other_bytes(path, text, error)
        # Every byte is a character of the old encoding of Western Windows but for five.
        text, note = Text(content, "cp1252", "replace"), "encoding cp1252 (not UTF-8)"
        fault = _fault(path, text)
    return (text, note, None) if fault is None else (nothing, "", fault)


def _encoding(head: bytes) -> tuple[str | None, str]:
    """The encoding that a file's begin shows, and a note on it."""
    for mark, name in _MARKS:
        if head.startswith(mark):
            return name, "" if mark == codecs.BOM_UTF8 else f"encoding {name.upper()}"
    zeros = head.count(b"\0")
    if not zeros:
        return "utf-8", ""
    # A text in Latin letters without a mark: every other byte is zero.
    for name, part in (("utf-16-le", head[1::2]), ("utf-16-be", head[0::2])):
        if part.count(b"\0") == zeros and zeros > 0.8 * len(part):
            return name, f"encoding {name.upper()}"
    return None, ""


def _is_known(name: str) -> bool:
    try:
        b"".decode(name)
    except LookupError:  # or one from bytes to bytes
        return False
    return True


def _no_encoding(path: Path, name: str) -> Fault:
    return Fault(
        what="no such encoding",
        file=str(path),
        got=repr(name),
        expected='one such as "utf-8", "utf-16" or "cp1252"',
        remedy="Correct `encoding`, or leave it out: it is found.",
    )


def _fault(path: Path, text: Text) -> Fault | None:
    """What no log holds: zero bytes, a line of a book's length."""
    row, length = 1, 0
    for piece in text.pieces():
        if "\0" in piece:
            row += piece.count("\n", 0, piece.index("\0"))
            return dataclasses.replace(_no_text(path, "a zero byte"), row=row)
        end = max(piece.rfind("\n"), piece.rfind("\r")) + 1
        length = len(piece) - end if end else length + len(piece)
        row += piece.count("\n")
        if length > _LONGEST:
            got = f"a line of more than {_LONGEST:,} characters"
            return dataclasses.replace(_no_text(path, got), row=row)
    return None


def _other_bytes(path: Path, text: Text, error: UnicodeError) -> Fault:
    start = error.start if isinstance(error, UnicodeDecodeError) else 0
    row = text.content.count(b"\n", 0, start) + 1
    got = f"the byte 0x{text.content[start]:02x} in a text that should be {text.encoding}"
    return dataclasses.replace(_no_text(path, got), row=row)


def _no_text(path: Path, got: str) -> Fault:
    return Fault(
        what="not a text that can be read",
        file=str(path),
        got=got,
        expected="a CSV or another text in columns, a TDMS or a MAT file",
        remedy="Export it as CSV (UTF-8), or state its `encoding`.",
    )
