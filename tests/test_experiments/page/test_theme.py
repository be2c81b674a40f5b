"""Contrast of the pages' colours, WCAG 2.2's success criteria 1.4.3 and 1.4.11."""

import re

import pytest

from experiments.page.theme import (
    DRAWN,
    PANEL,
    PAPER,
    SHADES,
    TEXTS,
    contrast,
    declarations,
    themed,
)

PALE = ("d-grid", "d-band", "d-steel", "d-body", "d-orange", "d-sky")
"""Grounds, and two colours that are drawn thick or with a marker of their own."""


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


@pytest.mark.parametrize("night", [False, True])
@pytest.mark.parametrize("word", [*TEXTS, DRAWN[0], DRAWN[-1]], ids=lambda shade: shade.name)
def test_words_stand_out_from_their_ground(word, night):
    for ground in (PAPER, PANEL):
        pair = (word.night, ground.night) if night else (word.day, ground.day)
        assert contrast(*pair) >= 4.5


@pytest.mark.parametrize("line", [s for s in DRAWN if s.name not in PALE], ids=lambda s: s.name)
def test_lines_stand_out_from_the_page(line):
    assert contrast(line.day, PAPER.day) >= 3
    assert contrast(line.night, PAPER.night) >= 3


def test_every_colour_has_its_name_once():
    assert len({shade.name for shade in SHADES}) == len(SHADES)
    for night in (False, True):
        assert re.findall(r"--([\w-]+):", declarations(night=night)) == [s.name for s in SHADES]


def test_a_drawing_takes_the_pages_colours_and_keeps_the_others():
    svg = (
        '<path style="fill: #0072b2; stroke: #123456"/>'
        '<text style="fill: #1a1a1a">#0072b2</text>'
    )
    assert themed(svg) == (
        '<path style="fill: var(--d-blue); stroke: #123456"/>'
        '<text style="fill: var(--ink)">#0072b2</text>'
    )
