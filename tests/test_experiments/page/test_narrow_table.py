"""Laws of tables and sentences in few columns."""

import io

import hypothesis
from hypothesis import strategies as st
from rich.console import Console

from experiments.page.console_text import print_table
from experiments.page.narrow_table import narrowed
from experiments.page.table import Table
from experiments.page.wrapping import wrapped

WORD = st.text("abcdxyz0179.,%()", min_size=1, max_size=12)
CELL = st.lists(WORD, min_size=1, max_size=6).map(" ".join)


@st.composite
def tables(draw):
    columns = draw(st.integers(1, 8))
    row = st.tuples(*[CELL] * columns)
    spare = st.lists(st.integers(1, columns - 1), unique=True) if columns > 1 else st.just([])
    return {
        "title": "",
        "header": draw(row),
        "rows": tuple(draw(st.lists(row, min_size=1, max_size=4))),
        "words": tuple(draw(st.lists(st.integers(0, columns - 1)))),
        "spare": tuple((column,) for column in draw(spare)),
    }


@hypothesis.given(table=tables(), width=st.integers(34, 140))
def test_every_word_of_a_kept_column_is_whole_and_every_line_fits(table, width):
    table = Table(**table)
    file = io.StringIO()
    print_table(Console(file=file, width=width), table)
    printed = file.getvalue().splitlines()
    gone = narrowed(table, width).left_out
    note = next((n for n, line in enumerate(printed) if line.startswith("(no room")), None)
    body = printed if note is None else printed[:note]
    assert all(len(line) <= width for line in body)
    words = {word for line in body for word in line.split()}
    kept = [n for n, name in enumerate(table.header) if name not in gone]
    wanted = {w for row in (table.header, *table.rows) for n in kept for w in row[n].split()}
    assert wanted <= words


@hypothesis.given(table=tables())
def test_where_there_is_room_no_column_goes_and_no_row_is_broken(table):
    wide = narrowed(Table(**table), 10_000)
    assert not wide.left_out
    (part,) = wide.parts
    assert all(len(cell.lines) == 1 for row in (part.header, *part.rows) for cell in row)


@hypothesis.given(text=CELL, width=st.integers(20, 60))
def test_a_wrapped_text_is_the_same_text(text, width):
    lines = wrapped(text, width, hanging="  ")
    assert " ".join(" ".join(lines).split()) == " ".join(text.split())


def test_a_number_keeps_its_unit():
    assert wrapped("a vibration of 5.0 mm before", 18) == ["a vibration of", "5.0 mm before"]


def test_a_path_is_longer_than_the_terminal_and_whole():
    path = "/a/rather/long/folder/with-a-name/results.json"
    assert wrapped(f"wrote {path} now", 20) == ["wrote", path, "now"]


def test_spare_columns_go_before_a_word_is_broken_and_are_named():
    table = Table("", ("run", "rows"), (("0007-pseudo-impulse", "3000"),), spare=((1,),))
    assert narrowed(table, 24).left_out == ("rows",)
    assert narrowed(table, 25).left_out == ()
