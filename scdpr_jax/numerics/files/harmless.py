"""What may be shown of a text that comes from somebody else's file.

A name can hold what moves a terminal's cursor, turns the direction of writing round, begins a
new line of a table, or is a formula to a spreadsheet. None of that is refused as it is read,
since a log is a log; it is written out where it is shown.
"""

import re
import unicodedata

LONGEST = 300
"""Characters of a part of a message."""
LINES = 12
"""Lines of a message."""
_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_ESCAPED = re.compile(r"'+[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def printable(text: str) -> str:
    """A text as one line of a terminal may show it.

    Args:
        text: The text, with names from wherever.

    Returns:
        The same; control characters, line ends, marks of direction and lone surrogates are
        written out.
    """
    if text.isprintable():
        return text
    return "".join(map(_shown, text))


def _shown(mark: str) -> str:
    # Blanks of other widths are no printable characters to Python.
    if mark.isprintable() or unicodedata.category(mark) == "Zs":
        return mark
    return mark.encode("unicode_escape").decode()


def shortened(text: str, most: int = LONGEST) -> str:
    """A text no longer than a message can bear.

    Args:
        text: The text.
        most: Characters that it may have.

    Returns:
        The same, its middle left out where it is longer.
    """
    if len(text) <= most:
        return text
    side = most // 2 - 2
    return f"{text[:side]} … {text[-side:]}"


def represented(value: object, most: int = 80) -> str:
    """A value of a document, short enough for a message.

    Args:
        value: The value.
        most: Characters that it may have.

    Returns:
        How Python writes it, its middle left out where it is longer.
    """
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print integers of thousands of digits
        return "a number too long to print"
    return shortened(text, most)


def message(text: str) -> str:
    """A message of several lines as a terminal may show it.

    Args:
        text: The message.

    Returns:
        At most twelve lines, each of a length that can be read, without what isn't printable.
    """
    lines = [shortened(printable(line), 3 * LONGEST) for line in text.splitlines()] or [""]
    if len(lines) > LINES:
        more = len(lines) - LINES + 1
        lines = [*lines[: LINES - 1], f"  and {more} lines more."]
    return "\n".join(lines)


def cell(text: str) -> str:
    """A text as a cell of a table that a spreadsheet may open.

    Args:
        text: The text.

    Returns:
        The same, behind an apostrophe where a spreadsheet would take it for a formula; a
        number stays one.
    """
    if _FORMULA.match(text) and not _NUMBER.fullmatch(text):
        return "'" + text
    return text


def text_of_cell(written: str) -> str:
    """What `cell` was given.

    Args:
        written: A cell.

    Returns:
        Its text.
    """
    return written[1:] if _ESCAPED.match(written) else written
