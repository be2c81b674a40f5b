"""Tables and sentences in a terminal."""

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from experiments.page.table import Table as PlainTable


def rich_table(plain_table: PlainTable) -> Table:
    """A report's table for the terminal.

    Args:
        plain_table: The table.

    Returns:
        The same, its first column to the left and the others to the right.
    """
    table = Table(
        title=plain_table.title,
        title_justify="left",
        box=None,
        pad_edge=False,
        header_style="bold",
    )
    for index, name in enumerate(plain_table.header):
        # A word that is too long for its column goes on below: nothing is cut.
        table.add_column(Text(name), justify="right" if index else "left", overflow="fold")
    for row in plain_table.rows:
        table.add_row(*(Text(cell) for cell in row))
    return table


def print_lines(console: Console, lines: Sequence[str]) -> None:
    """Print sentences as a list.

    Args:
        console: Where to print them.
        lines: The sentences.
    """
    for line in lines:
        console.print(Text(f"- {line}"), soft_wrap=False)
