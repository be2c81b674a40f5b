"""Figures drawn by processes of their own are those drawn at once."""

import numpy as np
import pytest
from markupsafe import escape

from experiments.page import style
from experiments.page.drawing import draw, drawing_aside


@style.styled
def line(*, width, columns=1):
    figure, grid = style.panels(1, columns, height=2.0, width=width)
    for axes in grid:
        axes.plot(np.arange(3.0))
    return figure


def test_a_figure_drawn_aside_is_the_same_to_the_letter():
    sizes = ({"width": 5.0}, {"width": 10.0, "columns": 2})
    whole, cut = (escape(draw(line(**size), "fig1", "two < three")) for size in sizes)
    with drawing_aside(1) as aside:
        pictures = [aside(line(**size), "fig1", "two < three") for size in sizes]
        assert [escape(picture) for picture in pictures] == [whole, cut]
    assert whole.startswith('<svg role="img" aria-label="two &lt; three"')
    assert cut.startswith('<div class="panels"')


def test_what_goes_wrong_is_told_where_the_picture_is_shown():
    with drawing_aside(1) as aside:
        picture = aside(line(width=5.0), "not a name", "")
        with pytest.raises(ValueError, match="letters, digits and hyphens"):
            escape(picture)
