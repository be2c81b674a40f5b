"""How a text in columns is written: separator, decimal point, comments, and what cells say."""

import contextlib
import csv
import dataclasses
import re

from identification.campaign.quantities import LARGEST

SEPARATORS = (";", "\t", ",", "|", " ")
"""Separators that are tried; a blank stands for any number of blanks and tabs."""
COMMENTS = ("#", "%", "//", "!", "*")
"""What a line of comment begins with."""
_MISSING = frozenset(
    (
        "",
        "nan",
        "na",
        "n/a",
        "#n/a",
        "#nv",
        "null",
        "none",
        "-",
        "--",
        "---",
        "?",
        "inf",
        "-inf",
    )
)
"""Cells that say that there is no number, in lower case."""
# One way to match each digit: two would take a cell of a book's length for ever.
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][+-]?\d{1,4})?", re.ASCII)
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:[.'’\u00a0\u202f ]\d{3})+,\d+", re.ASCII)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dialect:
    """How a text in columns is written, as far as somebody says it."""

    separator: str | None = None
    """What stands between cells, None to find it."""
    decimal: str | None = None
    """The decimal point, None to find it."""
    encoding: str | None = None
    """The encoding, None to find it."""
    skip: int | None = None
    """Lines before the header, None to find it."""


def is_comment(line: str) -> bool:
    """Whether a line is a comment.

    Args:
        line: The line.

    Returns:
        Whether it begins with a mark of a comment.
    """
    return line.lstrip(" \t\"'").startswith(COMMENTS)


def split(line: str, separator: str) -> tuple[str, ...]:
    """A line's cells, trimmed and without quotation marks.

    Args:
        line: The line.
        separator: What stands between them.

    Returns:
        The cells.
    """
    cells = line.split() if separator == " " else line.split(separator)
    if '"' in line:
        text = " ".join(line.split()) if separator == " " else line
        reader = csv.reader([text], delimiter=separator, skipinitialspace=True)
        with contextlib.suppress(csv.Error):  # a lone mark, or a cell of a book's length
            cells = next(reader, [])
    return tuple(cell.strip(" \t\u00a0'\"") for cell in cells)


def number(cell: str, decimal: str) -> float | None:
    """The number in a cell.

    Args:
        cell: The cell, trimmed.
        decimal: The decimal point.

    Returns:
        The number, None if it is none.
    """
    if decimal == ",":
        if _GROUPED.fullmatch(cell):
            cell = re.sub(r"[.'’\u00a0\u202f ]", "", cell)
        elif "." in cell:
            # A thousand or a thousandth: who wrote it knows.
            return None
        cell = cell.replace(",", ".")
    if _NUMBER.fullmatch(cell) is None:
        return None
    value = float(cell.replace("d", "e").replace("D", "e"))
    return value if abs(value) <= LARGEST else None


def is_missing(cell: str) -> bool:
    """Whether a cell says that there is no number.

    Args:
        cell: The cell, trimmed.

    Returns:
        Whether it does.
    """
    return cell.lower() in _MISSING
