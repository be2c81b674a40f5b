"""How a text in columns is written: separator, decimal point, comments, header, units.

A guess by counting marks in the first line fails on a comment that holds semicolons, or on
decimal commas between tabs. So every way to read the text is tried on its rows, and the one is
taken that makes most numbers of them: a wrong separator leaves cells such as `0,1;2` that no
number is.
"""

import contextlib
import csv
import dataclasses
import itertools
import re
from collections.abc import Sequence

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
_SAMPLE = 400
"""Rows that are tried."""
_UNIT = re.compile(r"[\[(<]?[^\[\]()<>]{0,14}[\])>]?")
_UNIT_WORDS = re.compile(
    r"(m?s|us|µs|μs|min|h|k?hz|m|mm|cm|um|µm|in|m?v|volts?|m?a|n|kn|m?rad|deg|°|degrees?|rev|turns?|"
    r"counts?|cts?|inc|incr|ticks?|pulses?|1|-|n/a|utc|m/s\^?2|m/s²|mm/s\^?2|mm/s²|g|"
    r"seconds?|secs?|milliseconds?|millimet(?:er|re)s?|met(?:er|re)s?|radians?|%|bool|text|"
    r"[a-zµ°]{1,4}(?:/[a-z]{1,3}\^?\d?)?)",
    re.IGNORECASE,
)


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


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """How a text was found to be written."""

    separator: str
    """What stands between cells."""
    decimal: str
    """The decimal point."""
    header: tuple[str, ...]
    """Names of the columns; their numbers from 1 where there is no header."""
    units: tuple[str, ...]
    """Units in a row of their own, empty texts where there is none."""
    rows: tuple[tuple[int, tuple[str, ...]], ...]
    """The rows below, each with its line from 1."""
    stated: bool
    """Whether there is a header."""


def layout(text: str, dialect: Dialect) -> Layout | None:
    """How a text is written, and its rows.

    Args:
        text: The text.
        dialect: What is known of it.

    Returns:
        Its layout, None if it isn't columns of numbers in any way that is tried.
    """
    lines = list(enumerate(text.splitlines(), start=1))[dialect.skip or 0 :]
    solid = [(number, line) for number, line in lines if line.strip(" \t;,")]
    plain = [each for each in solid if not is_comment(each[1])]
    if not plain:
        return None
    separators = SEPARATORS if dialect.separator is None else (dialect.separator,)
    decimals = (".", ",") if dialect.decimal is None else (dialect.decimal,)
    tried = plain[len(plain) // 2 :][:_SAMPLE]
    pairs = [
        (separator, decimal)
        for separator, decimal in itertools.product(separators, decimals)
        if separator != decimal or _is_quoted(tried)
    ]
    scores = [_score([split(line, s) for _, line in tried], d) for s, d in pairs]
    if not scores or not max(scores):
        return None
    separator, decimal = pairs[scores.index(max(scores))]
    return _laid_out(solid, separator, decimal, skipped=dialect.skip is not None)


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


def _is_quoted(lines: Sequence[tuple[int, str]]) -> bool:
    """Whether commas can be both: `"1,5","2,5"`."""
    return any('","' in line or '", "' in line for _, line in lines[:20])


def _score(rows: Sequence[tuple[str, ...]], decimal: str) -> int:
    """How many numbers a way to read the rows makes; none if they don't line up."""
    widths = [len(row) for row in rows]
    width = max(set(widths), key=widths.count)
    level = [row for row in rows if len(row) == width]
    if 2 * len(level) <= len(rows):
        return 0
    made = lost = 0
    for row in level:
        for cell in row:
            if number(cell, decimal) is not None:
                made += 1
            elif not is_missing(cell):
                lost += 1
    # What is no number is a column of words, or the wrong way to read it. Rows that don't line
    # up count for nothing: an empty cell between blanks is one that is gone.
    return max(made - 2 * lost, 0) * 100 + (made > lost)


def _laid_out(
    lines: Sequence[tuple[int, str]], separator: str, decimal: str, *, skipped: bool
) -> Layout | None:
    """Header, units and rows of a text whose separator is known."""
    plain = [(n, split(line, separator)) for n, line in lines if not is_comment(line)]
    widths = [len(cells) for _, cells in plain[len(plain) // 2 :]]
    width = max(set(widths), key=widths.count)
    first = next((k for k, (_, c) in enumerate(plain) if _is_data(c, width, decimal)), None)
    if first is None:
        return None
    begin = plain[first][0]
    above = [each for each in lines if each[0] < begin]
    header, units = _above(above[:2] if skipped else above, separator, width)
    names = header or tuple(str(place + 1) for place in range(width))
    return Layout(
        separator=separator,
        decimal=decimal,
        header=names,
        units=units,
        rows=tuple(plain[first:]),
        stated=bool(header),
    )


def _above(
    lines: Sequence[tuple[int, str]], separator: str, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Header and units in the lines above the numbers, empty where there are none.

    A comment is a header only where no other line can be.
    """
    rows = [(is_comment(line), split(_bare(line), separator)) for _, line in lines]
    rows = [(comment, cells) for comment, cells in rows if _fits(cells, width)]
    units: tuple[str, ...] = ()
    if len(rows) > 1 and _are_units(rows[-1][1]):
        units = tuple(cell.strip("[]()<> ") for cell in rows.pop()[1])
    names = [cells for comment, cells in rows if not comment] or [cells for _, cells in rows]
    return (_padded(names[-1], width) if names else ()), _padded(units, width)


def _bare(line: str) -> str:
    """A line without the mark of a comment."""
    return line.lstrip(" \t\"'").lstrip("#%/!* ") if is_comment(line) else line


def _is_data(cells: tuple[str, ...], width: int, decimal: str) -> bool:
    """Whether a row is one of numbers, and no header or row of units."""
    numbers = sum(number(cell, decimal) is not None for cell in cells)
    missing = sum(is_missing(cell) for cell in cells)
    return len(cells) == width and numbers > 0 and 3 * numbers >= width - missing


def _fits(cells: tuple[str, ...], width: int) -> bool:
    """Whether a line above the numbers can be their header."""
    while cells and not cells[-1]:
        cells = cells[:-1]
    return len(cells) in (width, width - 1) and any(cells)


def _are_units(cells: tuple[str, ...]) -> bool:
    """Whether a row says units and no names."""
    words = [cell for cell in cells if cell]
    bracketed = [cell[:1] in "[(<" for cell in words]
    short = [_UNIT_WORDS.fullmatch(cell.strip("[]()<> ")) is not None for cell in words]
    return bool(words) and all(map(_UNIT.fullmatch, words)) and (all(bracketed) or all(short))


def _padded(cells: tuple[str, ...], width: int) -> tuple[str, ...]:
    return (*cells[:width], *("",) * (width - len(cells)))
