"""The text of a file in whatever encoding it was written."""

import codecs
import dataclasses
from pathlib import Path

from identification.campaign.faults import Fault
from scdpr_jax.numerics.files import regular

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


def read_text(path: Path, encoding: str | None) -> tuple[str, str, Fault | None]:
    """A file's text.

    Args:
        path: The file.
        encoding: Its encoding, None to find it.

    Returns:
        The text; how it was found to be written, empty where it is UTF-8 or as stated; the
        fault where there is no text.
    """
    with regular(path).open("rb") as file:
        head = file.read(_HEAD)
        if not head.strip(b"\0"):
            return "", "", _no_text(path, "nothing" if not head else "zero bytes")
        for begin, what in _BINARY.items():
            if head.startswith(begin):
                return "", "", _no_text(path, what)
        name, note = _encoding(head) if encoding is None else (encoding, "")
        if name is None:
            return "", "", _no_text(path, "bytes that are no text")
        content = head + file.read()
    return _decoded(path, content, name, note, stated=encoding is not None)


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


def _decoded(
    path: Path, content: bytes, name: str, note: str, *, stated: bool
) -> tuple[str, str, Fault | None]:
    try:
        codecs.lookup(name)
    except LookupError:
        fault = Fault(
            what="no such encoding",
            file=str(path),
            got=repr(name),
            expected='one such as "utf-8", "utf-16" or "cp1252"',
            remedy="Correct `encoding`, or leave it out: it is found.",
        )
        return "", "", fault
    try:
        text = content.decode(name)
    except UnicodeDecodeError as error:
        if stated or name != "utf-8":
            row = content.count(b"\n", 0, error.start) + 1
            got = f"the byte 0x{content[error.start]:02x} in a text that should be {name}"
            return "", "", dataclasses.replace(_no_text(path, got), row=row)
        # Every byte is a character of the old encoding of Western Windows but for five.
        text, note = content.decode("cp1252", errors="replace"), "encoding cp1252 (not UTF-8)"
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        return "", "", dataclasses.replace(_no_text(path, "a zero byte"), row=row)
    return text.removeprefix("\ufeff"), note, None


def _no_text(path: Path, got: str) -> Fault:
    return Fault(
        what="not a text that can be read",
        file=str(path),
        got=got,
        expected="a CSV or another text in columns, a TDMS or a MAT file",
        remedy="Export it as CSV (UTF-8), or state its `encoding`.",
    )
