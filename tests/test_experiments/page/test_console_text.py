from rich.console import Console

from experiments.page.console_text import print_table
from experiments.page.table import Table

TABLE = Table("Runs", ("run", "a long name of a column", "status"), (("0001", "1.25", "weak"),))


def printed(table, *, width=100, **options):
    console = Console(width=width, record=True)
    print_table(console, table, **options)
    return console.export_text(styles=True)


def test_a_narrow_terminal_folds_the_table_and_cuts_nothing():
    folded = printed(TABLE, width=16)
    assert "…" not in folded
    assert "".join(["a", "long", "name"]) in "".join(folded.replace("1.25", "").split())


def test_numbers_end_at_the_right_and_words_begin_at_the_left():
    header, line = printed(TABLE).splitlines()[-2:]
    assert line.index("1.25") > line.index("0001") + len("0001  ")
    assert line.rstrip().endswith("1.25    weak")
    as_words = Table(TABLE.title, TABLE.header, TABLE.rows, words=(0, 1, 2))
    assert "0001  1.25" in printed(as_words)


def test_markup_in_a_cell_is_printed_as_it_is():
    assert "[red]x[/red]" in printed(Table("", ("run",), (("[red]x[/red]",),)))


def test_a_cell_is_styled_by_what_stands_in_it():
    console = Console(width=60, force_terminal=True, color_system="standard", record=True)
    print_table(console, TABLE, styles={"weak": "yellow"})
    assert "\x1b[33mweak" in console.export_text(styles=True)
