"""Figures drawn by processes of their own are those drawn at once."""

import numpy as np
import pytest
from markupsafe import escape

from experiments.page import style
from experiments.page.pictures.drawing import draw, draws_by
from experiments.runtime import processes_aside


@style.styled
def line(*, panels):
    figure, grid = style.panels(1, panels, height=2.0, width=5.0 * panels)
    for axes in grid:
        axes.plot(np.arange(3.0), label="line")
    style.figure_legend(figure, grid[0])
    return figure


def test_a_figure_drawn_aside_is_the_same_to_the_letter():
    at_once = [escape(draw(line(panels=count), "fig1", "two < three")) for count in (1, 2)]
    with processes_aside(1) as processes:
        aside = draws_by(processes)
        later = [aside(line(panels=count), "fig1", "two < three") for count in (1, 2)]
        assert [escape(picture) for picture in later] == at_once
    assert at_once[0].startswith('<svg role="img" aria-label="two &lt; three"')
    assert at_once[1].startswith('<div class="panels" role="img" aria-label="two &lt; three"')


def test_what_goes_wrong_is_told_where_the_picture_is_shown():
    with processes_aside(1) as processes:
        picture = draws_by(processes)(line(panels=1), "not a name", "")
        with pytest.raises(ValueError, match="letters, digits and hyphens"):
            escape(picture)
