"""A TOML document and where its keys stand."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from identification.campaign.faults import Fault
from identification.campaign.tables.text_file import read_text
from scdpr_jax.numerics.files.given import DOCUMENT
from scdpr_jax.numerics.files.harmless import represented, shortened

FORMAT = 1
"""Number of the format that is read and written."""

_TABLE = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]")
_LINE = 400
"""Characters of a line in which a heading or a key is looked for."""
_WORD = r"(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')"
_DEEP = re.compile(rf"(?<![\w-]){_WORD}(?:[ \t]*+\.[ \t]*+{_WORD}){{24,}}", re.ASCII)
"""A key of so many parts that the time to read it, which grows as their square, counts."""
_POSITION = re.compile(r"\(at line (\d+), column (\d+)\)")


def read_document(path: Path) -> tuple[dict[str, Any] | None, str, Fault | None]:
    """A TOML document of this format.

    Args:
        path: The file.

    Returns:
        The document without its `format`, None if it can't be read; its text; the fault.
    """
    text, fault = read_text(path, most=DOCUMENT)
    if fault is not None:
        return None, text, fault
    deep = _DEEP.search(text)
    if deep is not None:
        return None, text, _too_deep(text, deep)
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        return None, text, _syntax(text, error)
    number = document.pop("format", None)
    if type(number) is not int or number != FORMAT:
        return None, text, _format(text, number)
    return document, text, None


def row_of(text: str, path: Sequence[str]) -> int | None:
    """The line in which a key stands.

    Args:
        text: The document's text.
        path: The key after the names of its tables.

    Returns:
        The line from 1: the key's, its table's if the key isn't there, or None.
    """
    if not path:
        return None
    table = ""
    table_line = None
    for number, line in enumerate(text.splitlines(), start=1):
        heading = _TABLE.match(line[:_LINE])
        if heading is not None:
            table = heading[1]
            if table == ".".join(path[:-1]):
                table_line = number
            if table == ".".join(path):
                return number
        elif table == ".".join(path[:-1]):
            name = line[:_LINE].partition("=")[0].strip().strip("\"'")
            if name == path[-1]:
                return number
    return table_line


def _syntax(text: str, error: Exception) -> Fault:
    position = _POSITION.search(str(error))
    row = int(position[1]) if position else None
    if "end of document" in str(error):
        row = len(text.splitlines())
    return Fault(
        what="not valid TOML",
        row=row,
        got=shortened(str(error)),
        expected='lines like key = "value" below headings like [table]',
        remedy="Correct that line; texts and quantities stand in quotation marks.",
    )


def _too_deep(text: str, found: re.Match[str]) -> Fault:
    return Fault(
        what="a key of too many parts",
        row=text.count("\n", 0, found.start()) + 1,
        got=represented(found[0]),
        expected="tables inside of each other a few times at most",
        remedy="Correct that line.",
    )


def _format(text: str, number: object) -> Fault:
    there = number is not None
    remedy = "Read it with the version that wrote it, or export it again as format 1."
    return Fault(
        what="not a format that is known here" if there else "the format isn't stated",
        row=row_of(text, ["format"]),
        key="format",
        got=represented(number) if there else "no such key",
        expected=f"format = {FORMAT}",
        remedy=remedy if there else f"Write `format = {FORMAT}` in the first line.",
    )
