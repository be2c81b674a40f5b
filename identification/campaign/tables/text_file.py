"""A text file as it comes from a lab's machines, or the fault of one."""

import dataclasses
from pathlib import Path

from identification.campaign.faults import Fault, fault_of
from scdpr_jax.numerics.files.given import FileError, read_given


def read_text(path: Path, *, most: int) -> tuple[str, Fault | None]:
    """A file's text.

    Args:
        path: The file.
        most: Its largest size [bytes].

    Returns:
        The text, without a byte order mark; and the fault if there is none to be read.
    """
    content, fault = read_text_bytes(path, most=most)
    return content.decode("utf-8-sig"), fault


def read_text_bytes(path: Path, *, most: int) -> tuple[bytes, Fault | None]:
    """The bytes of a file that holds a text: a quarter of what it may take as one.

    Args:
        path: The file.
        most: Its largest size [bytes].

    Returns:
        The text in UTF-8, perhaps behind a byte order mark; and the fault if there is none.
    """
    try:
        content = read_given(path, most=most)
    except FileError as error:
        return b"", fault_of(error)
    except FileNotFoundError:
        return b"", Fault(
            what="the file is missing",
            got="no such file",
            expected=f"the file {path.name}",
            remedy="Copy it there, or check its name.",
        )
    except OSError as error:
        return b"", Fault(
            what="the file can't be read",
            got=f"{error.strerror}",
            expected="a readable text file",
            remedy="Check what it is and its permissions; copy the log itself there.",
        )
    binary = Fault(
        what="not text in UTF-8",
        row=content.count(b"\n") + 1,
        expected="a text file in UTF-8",
        remedy="Save it as plain text in UTF-8; a TDMS or MAT log goes through the importers.",
    )
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        got = f"the byte 0x{content[error.start]:02x}"
        return b"", dataclasses.replace(binary, row=row, got=got)
    if b"\0" in content:
        row = content.count(b"\n", 0, content.index(b"\0")) + 1
        return b"", dataclasses.replace(binary, row=row, got="a zero byte")
    return content, None
