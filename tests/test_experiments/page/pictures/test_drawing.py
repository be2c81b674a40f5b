"""Figures drawn by processes of their own are those drawn at once."""

import numpy as np
import pytest
from markupsafe import escape

from experiments.page import style
from experiments.page.pictures.drawing import draw, drawing_aside


@style.styled
def line(*, width):
    figure, (axes,) = style.panels(1, 1, height=2.0, width=width)
    axes.plot(np.arange(3.0))
    return figure


def test_a_figure_drawn_aside_is_the_same_to_the_letter():
    def figure():
        return line(width=5.0)

    at_once = escape(draw(figure(), "fig1", "two < three"))
    with drawing_aside(1) as aside:
        picture = aside(figure(), "fig1", "two < three")
        assert escape(picture) == at_once
    assert at_once.startswith('<svg role="img" aria-label="two &lt; three"')


def test_what_goes_wrong_is_told_where_the_picture_is_shown():
    with drawing_aside(1) as aside:
        picture = aside(line(width=5.0), "not a name", "")
        with pytest.raises(ValueError, match="letters, digits and hyphens"):
            escape(picture)
