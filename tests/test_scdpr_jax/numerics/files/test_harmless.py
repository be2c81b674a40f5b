"""What is shown moves no cursor, forges no row, and is no formula."""

import csv
import io

import hypothesis
import hypothesis.strategies as st
import pytest

from scdpr_jax.numerics.files.harmless import (
    LINES,
    cell,
    message,
    printable,
    represented,
    shortened,
    text_of_cell,
)

HOSTILE = st.text(
    st.one_of(
        st.sampled_from("\x1b\x07\n\r\t\u202e\u2066\u200b\udcff'=+-@[]<&"), st.characters()
    )
)


@hypothesis.given(HOSTILE)
def test_a_shown_text_is_one_line_without_control(text):
    shown = printable(text)
    assert len(shown.splitlines()) <= 1
    assert not set(shown) & set("\x1b\x07\n\r\t\u202e\u2066\u200b")
    shown.encode()  # has no lone surrogate


@hypothesis.given(st.text(st.characters(categories=["L", "N", "P", "S", "Zs"])))
def test_what_is_harmless_is_shown_as_it_is(text):
    assert printable(text) == text


@hypothesis.given(HOSTILE)
def test_a_cell_is_no_formula_and_gives_its_text_back(text):
    written = cell(text)
    assert text_of_cell(written) == text
    if written[:1] in "=@\t\r" or (written[:1] in "+-" and written):
        assert written == "" or float(written) == float(text)


@pytest.mark.parametrize("formula", ["=cmd|'/c calc'!A0", "@SUM(A1)", "+1+1", "-2+3", "\t=1"])
def test_a_formula_is_behind_an_apostrophe(formula):
    assert cell(formula) == "'" + formula


@pytest.mark.parametrize("number", ["-1", "+0.5", "-1e-3", ".5", "0"])
def test_a_number_stays_a_number(number):
    assert cell(number) == number


@hypothesis.given(st.lists(HOSTILE))
def test_a_message_has_at_most_twelve_lines_that_can_be_shown(lines):
    shown = message("\n".join(lines)).split("\n")
    assert len(shown) <= LINES
    assert all(printable(line) == line for line in shown)


@hypothesis.given(st.text(), st.integers(20, 60))
def test_a_shortened_text_keeps_both_ends(text, most):
    shown = shortened(text, most)
    assert len(shown) <= max(most, 0)
    assert shown == text if len(text) <= most else shown[:5] == text[:5]


def test_a_number_too_long_to_print_is_told_so():
    assert represented(16**9000) == "a number too long to print"


def test_a_runs_name_goes_through_a_table_and_back():
    text = io.StringIO()
    csv.writer(text).writerow([cell("=1+1"), cell("a\nb")])
    assert list(map(text_of_cell, next(csv.reader(io.StringIO(text.getvalue()))))) == [
        "=1+1",
        "a\nb",
    ]
