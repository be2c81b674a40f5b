"""How the columns of a text are found: separator, decimal point, header, units, extent.

A guess by counting marks in the first line fails on a comment that holds semicolons, or on
decimal commas between tabs. So every way to read the text is tried on its rows, and the one is
taken that makes most numbers of them: a wrong separator leaves cells such as `0,1;2` that no
number is.
"""

import collections
import dataclasses
import itertools
import re
from collections.abc import Iterator, Sequence

from identification.bring.files.csv.dialect import (
    SEPARATORS,
    Dialect,
    is_comment,
    is_missing,
    number,
    split,
)
from identification.bring.files.csv.text import Text

_SAMPLE = 400
"""Rows that are tried."""
_ABOVE = 1000
"""Lines above the numbers in which a header is looked for."""

Row = tuple[int, tuple[str, ...]]
"""A row of a text in columns: its line, from 1, and its cells."""
_UNIT = re.compile(r"[\[(<]?[^\[\]()<>]{0,14}[\])>]?")
_UNIT_WORDS = re.compile(
    r"(m?s|us|µs|μs|min|h|k?hz|m|mm|cm|um|µm|in|m?v|volts?|m?a|n|kn|m?rad|deg|°|degrees?|rev|turns?|"
    r"counts?|cts?|inc|incr|ticks?|pulses?|1|-|n/a|utc|m/s\^?2|m/s²|mm/s\^?2|mm/s²|g|"
    r"seconds?|secs?|milliseconds?|millimet(?:er|re)s?|met(?:er|re)s?|radians?|%|bool|text|"
    r"[a-zµ°]{1,4}(?:/[a-z]{1,3}\^?\d?)?)",
    re.IGNORECASE,
)


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
    stated: bool
    """Whether there is a header."""
    text: Text
    """The text."""
    first: int
    """Line of the first row of numbers, from 1."""
    last: int
    """Line of the last one; below it are words at most."""
    count: int
    """Rows between the two, both counted."""
    footer: int
    """Lines of words below."""

    def rows(self) -> Iterator[Row]:
        """The rows, from the first to the last one, each with its line from 1."""
        for place, line in _plain(self.text, self.first - 1):
            if place > self.last:
                return
            yield place, split(line, self.separator)


def layout(text: Text, dialect: Dialect) -> Layout | None:
    """How a text is written.

    Args:
        text: The text.
        dialect: What is known of it.

    Returns:
        Its layout, None if it isn't columns of numbers in any way that is tried.
    """
    skip = dialect.skip or 0
    half = sum(1 for _ in _plain(text, skip)) // 2
    separators = SEPARATORS if dialect.separator is None else (dialect.separator,)
    decimals = (".", ",") if dialect.decimal is None else (dialect.decimal,)
    tried = list(itertools.islice(_plain(text, skip), half, half + _SAMPLE))
    if not tried:
        return None
    pairs = [
        (separator, decimal)
        for separator, decimal in itertools.product(separators, decimals)
        if separator != decimal or _is_quoted(tried)
    ]
    scores = [_score([split(line, s) for _, line in tried], d) for s, d in pairs]
    if not scores or not max(scores):
        return None
    separator, decimal = pairs[scores.index(max(scores))]
    return _laid_out(text, separator, decimal, half, skip=dialect.skip)


def _solid(text: Text, skip: int) -> Iterator[tuple[int, str]]:
    """Lines that aren't blank, with their numbers."""
    for each in itertools.islice(text.lines(), skip, None):
        if each[1].strip(" \t;,"):
            yield each


def _plain(text: Text, skip: int) -> Iterator[tuple[int, str]]:
    """Those of them that are no comments."""
    return (each for each in _solid(text, skip) if not is_comment(each[1]))


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
    text: Text, separator: str, decimal: str, half: int, *, skip: int | None
) -> Layout | None:
    """Header, units and extent of a text whose separator is known."""
    widths: collections.Counter[int] = collections.Counter()
    last = behind = 0
    for place, (row, line) in enumerate(_plain(text, skip or 0)):
        if place < half:
            continue
        cells = split(line, separator)
        widths[len(cells)] += 1
        if any(number(cell, decimal) is not None for cell in cells):
            last, behind = row, place + 1
        footer = place + 1 - behind
    width = max(sorted(widths), key=widths.__getitem__)
    rows = ((n, split(line, separator)) for n, line in _plain(text, skip or 0))
    numbered = enumerate(rows)
    before, first = next(
        ((k, n) for k, (n, cells) in numbered if _is_data(cells, width, decimal)), (0, 0)
    )
    if not 0 < first <= last:
        return None
    lines = itertools.takewhile(lambda each: each[0] < first, _solid(text, skip or 0))
    above = list(itertools.islice(lines, 2)) if skip is not None else [*_ends(lines)]
    header, units = _above(above, separator, width)
    return Layout(
        separator=separator,
        decimal=decimal,
        header=header or tuple(str(place + 1) for place in range(width)),
        units=units,
        stated=bool(header),
        text=text,
        first=first,
        last=last,
        count=behind - before,
        footer=footer,
    )


def _ends(lines: Iterator[tuple[int, str]]) -> Sequence[tuple[int, str]]:
    """The last of some lines: a header stands near its numbers."""
    return collections.deque(lines, _ABOVE)


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
    count = len(cells)
    while count and not cells[count - 1]:
        count -= 1
    return count > 0 and count in (width, width - 1)


def _are_units(cells: tuple[str, ...]) -> bool:
    """Whether a row says units and no names."""
    words = [cell for cell in cells if cell]
    bracketed = [cell[:1] in "[(<" for cell in words]
    short = [_UNIT_WORDS.fullmatch(cell.strip("[]()<> ")) is not None for cell in words]
    return bool(words) and all(map(_UNIT.fullmatch, words)) and (all(bracketed) or all(short))


def _padded(cells: tuple[str, ...], width: int) -> tuple[str, ...]:
    return (*cells[:width], *("",) * (width - len(cells)))
