"""What a report says and shows of the shapers between the cells' points."""

import dataclasses

import matplotlib
import numpy as np
import pytest
from report_samples import tuning

from experiments.figures.tuning.residual_vibration_map import residual_vibration_map
from experiments.page.page import Pictures
from experiments.reports.tuning.pictures import tuning_pictures
from experiments.studies.findings.tuning import between_the_cells_sentence, tuning_findings
from scdpr_jax.robot.prototype import consistent
from tuning.regions.residual_map import ResidualMap
from tuning.result.tuning import FittedSetting


def made_up(highest, *, pretension=350.0):
    """A ramp in x with one pose that is worse than all others."""
    x, y = np.linspace(0.2, 2.0, 30), np.linspace(0.2, 0.9, 12)
    left = np.tile(np.linspace(0.0, 0.5 * highest, 30), (12, 1))
    left[7, 3] = highest
    return ResidualMap(pretension, x, y, left, np.full_like(left, 0.057))


@pytest.fixture(scope="module")
def fitted():
    return dataclasses.replace(tuning(), robots=(FittedSetting(350.0, consistent()),))


def test_the_sentence_says_how_much_worse_it_is_and_where():
    said = between_the_cells_sentence((made_up(0.1), made_up(0.257, pretension=200.0)))
    assert "at most 25.7 % of a vibration of the held mode (x 386, y 645 mm, 200 N)" in said
    assert "up to 20.0 % of it more than stated for the region (x 386, y 645" in said


def test_a_map_that_is_bad_where_it_was_said_to_be_may_be_worse_elsewhere():
    bad = made_up(0.057)
    bad.promised[:, -1] = bad.residual[:, -1] = 1.0
    bad.residual[2, 5] = 0.357
    said = between_the_cells_sentence((bad,))
    assert "at most 100 % of" in said
    assert "up to 30.0 % of it more than stated for the region" in said


def test_the_sentence_does_not_speak_of_more_where_it_is_not():
    said = between_the_cells_sentence((made_up(0.057),))
    assert said.endswith("nowhere more than stated for the region.")


def test_the_cross_stands_at_the_worst_place(fitted):
    regions = [[one.region for one in fitted.shapers]] * 2
    figure = residual_vibration_map((made_up(0.2), made_up(0.1, pretension=200.0)), regions)
    for axes, expected in zip(figure.axes, ("20.0 %", "10.0 %"), strict=False):
        (cross,) = [line for line in axes.lines if line.get_marker() == "X"]
        assert cross.get_xdata() == pytest.approx(1e3 * made_up(0.1).x[3])
        assert cross.get_ydata() == pytest.approx(1e3 * made_up(0.1).y[7])
        texts = [text.get_text() for text in axes.findobj(matplotlib.text.Annotation)]
        assert f"worst: {expected}" in texts


def test_the_colours_reach_the_worst_of_all_maps(fitted):
    regions = [[one.region for one in fitted.shapers]] * 2
    figure = residual_vibration_map((made_up(0.2), made_up(0.31)), regions)
    filled = figure.axes[0].collections[0]
    assert filled.levels[0] == 0
    assert filled.levels[-1] >= 31


@pytest.mark.slow  # it computes the margins over the workspace, too
def test_a_tuning_with_fitted_robots_has_its_map(fitted):
    found = tuning_findings(fitted)
    pictures = tuning_pictures(found, robot=consistent(), picture=Pictures())
    assert sum("the cross is the worst place" in each.caption for each in pictures) == 1
    assert sum("Wherever a leg ends" in sentence for sentence in found.between_the_cells) == 1


def test_a_tuning_without_robots_has_none():
    found = tuning_findings(tuning())
    assert found.residual_maps == ()
    assert found.between_the_cells == ()
