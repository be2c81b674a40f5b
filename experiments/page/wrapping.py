"""Sentences in the columns that there are.

A terminal folds a long word wherever its last column is, and a path in two can't be pasted.
Python's `textwrap` would be simpler: it parts a number from its unit.
"""

import re
from collections.abc import Iterator

_UNIT = re.compile(
    r"[(\[]?(%|°|dB|rms|[kmµμ]?(m|s|g|N|V|Hz|rad|W)[²2]?([/·^ ][a-z0-9²]+)*)[)\].,;:]*$"
)
_NUMBER = re.compile(r"[±+−\-(\[]*\d[\d.,e+−\-]*$")
_INDENT = re.compile(r" *(\S+ {2,})?")
"""Blanks, and a word with a column after it."""
_SIGN = re.compile(r"[±…–=]$")


def wrapped(text: str, width: int, *, hanging: str = "") -> list[str]:
    """A text in lines that end between words.

    Args:
        text: The text.
        width: Columns that there are; a word that is longer has a line of its own.
        hanging: What every line but the first begins with.

    Returns:
        Its lines, one at least.
    """
    if len(text) <= width:
        return [text]
    first = _INDENT.match(text)[0]
    lines, line = [], first
    for word in _words(text[len(first) :]):
        longer = f"{line} {word}" if line not in (first, hanging) else line + word
        if len(longer) > width and line not in (first, hanging):
            lines.append(line)
            longer = hanging + word
        line = longer
    return [*lines, line]


def longest_word(text: str) -> int:
    """Columns of the longest part of a text that isn't broken.

    Args:
        text: The text.

    Returns:
        Its number of letters.
    """
    return max(map(len, _words(text)), default=0)


def _words(text: str) -> Iterator[str]:
    """Words, each number with its unit."""
    held = ""
    for word in text.split():
        last = held.rpartition(" ")[2]
        together = (_NUMBER.match(last) and _UNIT.match(word)) or _SIGN.match(last)
        if held and not together:
            yield held
            held = ""
        held = f"{held} {word}" if held else word
    if held:
        yield held
