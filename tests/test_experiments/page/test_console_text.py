import io

from rich.console import Console

from experiments.page.console_text import print_table
from experiments.page.table import Table

TABLE = Table("Runs", ("run", "a long name", "status"), (("0001", "1.25", "weak"),))


def printed(table, *, width=100, **options):
    file = io.StringIO()
    print_table(Console(file=file, width=width), table, **options)
    return file.getvalue()


def test_a_narrow_terminal_folds_the_table_and_cuts_nothing():
    folded = printed(TABLE, width=16)
    assert "…" not in folded
    for text in (*TABLE.header, *TABLE.rows[0]):
        assert all(letter in folded for letter in text)
    assert len(folded.splitlines()) > 3


def test_numbers_end_at_the_right_and_words_begin_at_the_left():
    assert printed(TABLE).splitlines()[-1] == "0001         1.25    weak"
    words = Table(TABLE.title, TABLE.header, TABLE.rows, words=(0, 1, 2))
    assert printed(words).splitlines()[-1].rstrip() == "0001  1.25         weak"


def test_markup_in_a_cell_is_printed_as_it_is():
    assert "[red]x[/red]" in printed(Table("", ("run",), (("[red]x[/red]",),)))


def test_a_cell_is_styled_by_what_stands_in_it():
    file = io.StringIO()
    console = Console(file=file, width=60, force_terminal=True, color_system="standard")
    print_table(console, TABLE, styles={"weak": "yellow"})
    assert "\x1b[33m  weak" in file.getvalue()
    assert "\x1b[33m 1.25" not in file.getvalue()
