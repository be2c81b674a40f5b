"""Tables and sentences in a terminal."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from rich.console import Console
from rich.text import Text

from experiments.page.narrow_table import GAP, Cell, narrowed
from experiments.page.table import Table
from experiments.page.wrapping import wrapped


def print_table(
    console: Console, table: Table, *, styles: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Print a table in the columns that there are.

    Args:
        console: Where to print it.
        table: The table.
        styles: Styles of cells by what stands in them.
    """
    if table.title:
        print_text(console, table.title, style="italic")
    narrow = narrowed(table, console.width)
    for part in narrow.parts:
        _print_row(console, part.header, lambda cell: "bold")
        for row in part.rows:
            _print_row(console, row, lambda cell: styles.get(cell.text, ""))
    if narrow.left_out:
        names = "; ".join(dict.fromkeys(narrow.left_out))
        print_text(console, f"(no room here for: {names})", style="dim")


def _print_row(console: Console, cells: Sequence[Cell], style: Callable[[Cell], str]) -> None:
    blank = [" " * len(cell.lines[0]) for cell in cells]
    for lines in itertools.zip_longest(*(cell.lines for cell in cells)):
        text = Text()
        for cell, line, empty in zip(cells, lines, blank, strict=True):
            text.append(" " * GAP if text else "")
            text.append(empty if line is None else line, style=style(cell))
        text.rstrip()
        console.print(text, soft_wrap=True)


def print_text(console: Console, text: str, *, style: str = "", hanging: str = "") -> None:
    """Print a text in lines that end between words.

    Args:
        console: Where to print it.
        text: The text, its line ends kept.
        style: How it is set.
        hanging: What every line but the first begins with.
    """
    for paragraph in text.split("\n"):
        for line in wrapped(paragraph, console.width, hanging=hanging):
            console.print(Text(line, style=style), soft_wrap=True)


def print_lines(console: Console, lines: Sequence[str]) -> None:
    """Print sentences as a list.

    Args:
        console: Where to print them.
        lines: The sentences.
    """
    for line in lines:
        print_text(console, f"- {line}", hanging="  ")
