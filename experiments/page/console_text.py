"""Tables and sentences in a terminal."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from rich.console import Console
from rich.table import Table
from rich.text import Text

from experiments.page.table import Table as PlainTable
from scdpr_jax.numerics.files.harmless import printable


def print_table(
    console: Console, table: PlainTable, *, styles: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Print a table.

    Args:
        console: Where to print it.
        table: The table.
        styles: Styles of cells by what stands in them.
    """
    console.print(_rich_table(table, styles))


def _rich_table(plain_table: PlainTable, styles: Mapping[str, str]) -> Table:
    table = Table(
        title=plain_table.title or None,
        title_justify="left",
        box=None,
        pad_edge=False,
        header_style="bold",
    )
    for index, name in enumerate(plain_table.header):
        side = "left" if index in plain_table.words else "right"
        # A word that is too long for its column goes on below: nothing is cut.
        table.add_column(Text(printable(name)), justify=side, overflow="fold")
    for row in plain_table.rows:
        table.add_row(*(Text(printable(cell), style=styles.get(cell, "")) for cell in row))
    return table


def print_lines(console: Console, lines: Sequence[str]) -> None:
    """Print sentences as a list.

    Args:
        console: Where to print them.
        lines: The sentences.
    """
    for line in lines:
        console.print(Text(f"- {printable(line)}"), soft_wrap=False)
