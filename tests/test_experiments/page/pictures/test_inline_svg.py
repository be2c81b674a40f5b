import re

import numpy as np
import pytest

from experiments.page.pictures.inline_svg import inline_svg
from experiments.page.style import new_figure, styled, thinned


@styled
def drawn():
    figure = new_figure(height=2.0)
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], "o-", label="a & b")
    axes.set_xlabel("x < y [mm]")
    return figure


def test_a_figure_has_no_address_and_no_prologue():
    svg = inline_svg(drawn(), name="one", description="what it shows")
    assert svg.startswith("<svg ")
    for unwanted in ("http", "<!DOCTYPE", "<?xml", "<metadata", "xmlns"):
        assert unwanted not in svg


def test_two_figures_of_a_page_share_no_identifier():
    first, second = (
        set(re.findall(r'\bid="([^"]+)"', inline_svg(drawn(), name=name, description="")))
        for name in ("one", "two")
    )
    assert first
    assert not first & second


def test_the_same_figure_gives_the_same_text():
    texts = {inline_svg(drawn(), name="one", description="d") for _ in range(2)}
    assert len(texts) == 1


def test_text_stays_text_and_is_escaped():
    svg = inline_svg(drawn(), name="one", description='a "quoted" <tag>')
    assert "x &lt; y [mm]" in svg
    assert 'aria-label="a &quot;quoted&quot; &lt;tag&gt;"' in svg


def test_a_figure_takes_the_width_of_its_column():
    opening = re.match(r"<svg[^>]*>", inline_svg(drawn(), name="one", description=""))[0]
    assert "viewBox" in opening
    assert not re.search(r"\b(width|height)=", opening)


@pytest.mark.parametrize("name", ["", "1", 'a"b', "a b"])
def test_a_name_that_breaks_identifiers_is_refused(name):
    with pytest.raises(ValueError, match="letters, digits and hyphens"):
        inline_svg(drawn(), name=name, description="")


def test_a_thinned_series_keeps_its_extremes_and_ends():
    x = np.linspace(0, 10, 20_000)
    y = np.sin(40 * x)
    y[12_345] = 7.0
    thin_x, thin_y = thinned(x, y, points=300)
    assert len(thin_x) <= 304
    assert np.all(np.diff(thin_x) > 0)
    assert (thin_y.max(), thin_y.min()) == (7.0, y.min())
    assert (thin_x[0], thin_x[-1]) == (0.0, 10.0)


def test_a_short_series_is_left_as_it_is():
    x = np.arange(5.0)
    assert thinned(x, x)[0] is x
