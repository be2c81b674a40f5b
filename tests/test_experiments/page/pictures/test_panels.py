import re

import numpy as np
import pytest

from experiments.page import style
from experiments.page.pictures.inline_svg import inline_svg
from experiments.page.pictures.panels import NARROW, Panel, parts


@style.styled
def figure(rows, columns, *, width=10.0):
    made, grid = style.panels(rows, columns, height=2.0 * rows, width=width)
    for number, axes in enumerate(grid):
        axes.plot(np.arange(3.0), label=f"line {number}")
        axes.set(xlabel="time [s]", title=f"panel {number}")
    style.figure_legend(made, grid[0])
    return made


def boxes(svg):
    found = re.findall(r'<svg viewBox="([^"]+)"', svg)
    return [tuple(map(float, box.split())) for box in found]


def test_a_wide_figure_is_cut_into_its_panels_and_its_legend():
    svg = inline_svg(figure(2, 2), name="a", description="four lines")
    legend, *panels = boxes(svg)
    assert len(panels) == 4
    # Half of 720 points each, and as wide as its neighbour below.
    assert all(320 < width <= 362 for _, _, width, _ in panels)
    assert panels[0][2] == panels[2][2]
    assert panels[0][3] == panels[1][3]
    assert legend[2] <= 362


@style.styled
def test_below_each_other_all_panels_have_the_scale_of_the_widest():
    made, _ = style.panels(1, 2, height=2.0, widths=(2.0, 1.0))
    svg = inline_svg(made, name="a", description="")
    shares = [float(share) for share in re.findall(r"--share: ([\d.]+)%", svg)]
    widths = [width for _, _, width, _ in boxes(svg)]
    assert shares[0] == 100.0
    assert shares[1] == pytest.approx(100 * widths[1] / widths[0], abs=0.06)


@style.styled
def test_a_legend_of_uneven_columns_is_no_wider_than_a_phone():
    # Drawn in four columns its first three entries are below each other, the others by twos.
    names = (
        "optimised",
        "zv",
        "mzv",
        "zvd",
        "ei",
        "zvdd",
        "2hump_ei",
        "3hump_ei",
        "recommended",
    )
    assert style.fitting_columns(names, 4) == 3


def test_all_panels_together_are_one_picture():
    svg = inline_svg(figure(1, 2), name="a", description="two <lines>")
    assert svg.startswith('<div class="panels" role="img" aria-label="two &lt;lines&gt;"')
    assert svg.count("aria-hidden") == 3


def test_no_word_and_no_line_of_a_figure_is_lost_in_cutting_it():
    whole = inline_svg(figure(2, 2, width=NARROW), name="a", description="")
    cut = inline_svg(figure(2, 2), name="a", description="")
    assert "panels" not in whole
    for number in range(4):
        assert f">panel {number}</text>" in cut
    assert cut.count("time [s]") == whole.count("time [s]") == 4
    targets = set(re.findall(r'\bid="([^"]+)"', cut))
    assert set(re.findall(r"url\(#([^)]+)\)|href=\"#([^\"]+)", cut)) != set()
    asked = set(re.findall(r'href="#([^"]+)"', cut)) | set(re.findall(r"url\(#([^)]+)\)", cut))
    assert asked <= targets


def test_a_figure_whose_parts_share_a_colour_bar_stays_whole():
    made = figure(1, 2)
    image = made.axes[0].imshow(np.eye(2))
    made.colorbar(image, ax=made.axes)
    assert "panels" not in inline_svg(made, name="a", description="")


def test_a_panel_that_the_drawing_lacks_is_named():
    panel = Panel("part-9", (0.0, 0.0, 1.0, 1.0), "1 / 1 / 2 / 2", wide=False)
    with pytest.raises(RuntimeError, match="part-9"):
        list(parts("<svg></svg>", [panel]))
