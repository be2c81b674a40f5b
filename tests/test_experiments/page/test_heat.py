import hypothesis
import hypothesis.strategies as st

from experiments.page.heat import Cell, shade
from experiments.page.theme import contrast

ENDS = ("#f4f8fb", "#f6c177", "#b5400a", "#4a1200")
share = st.floats(0, 1)


def test_a_shade_at_an_end_is_that_colour():
    assert shade(0.0, ENDS) == ENDS[0]
    assert shade(1.0, ENDS) == shade(7.0, ENDS) == ENDS[-1]
    assert shade(1 / 3, ENDS) == ENDS[1]


@hypothesis.given(share=share)
def test_words_are_read_on_every_shade(share):
    for ends in (ENDS, ("#0072b2", "#a9d1ea", "#ffffff", "#f3c39b", "#b04a00")):
        fill = shade(share, ends)
        word = "#ffffff" if Cell("1", fill).kind == "ink" else "#000000"
        assert contrast(word, fill) >= 4.5


def test_a_strong_cell_says_so_without_colour():
    assert Cell("−97", "#0072b2", strong=True).kind == "ink strong"
    assert Cell("–").kind == ""
