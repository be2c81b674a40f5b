"""Whether what is printed fits a terminal, without a broken word."""

import re

WIDTHS = (60, 80, 120)
"""Columns of terminals."""
PIPED = 100_000
"""Columns of what has none."""
PROGRESS = re.compile(r"^ *\d+ % .*\n", re.MULTILINE)
"""A line of progress: how many there are, and their figures, is the clock's."""


def tokens(text):
    return {word for word in PROGRESS.sub("", text).split() if word != "-"}


def check_fits(narrow, wide, width):
    """Nothing is wider than the terminal, no word is broken, and what goes is named."""
    for line in narrow.splitlines():
        assert len(line) <= width or len(line.split()) == 1, line
    assert "…" not in tokens(narrow) - tokens(wide)
    note = [line for line in narrow.splitlines() if line.startswith("(no room here for")]
    broken = tokens(narrow) - tokens(wide)
    assert not broken or note
    if not note:
        assert tokens(wide) == tokens(narrow)
