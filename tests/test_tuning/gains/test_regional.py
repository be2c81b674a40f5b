"""The choice of a region's shaper over legs that end there."""

import types

import numpy as np
import pytest

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper, padded
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from tuning.gains.legs import IMPULSES, plain_law
from tuning.gains.outcome import outcome
from tuning.gains.possible_robots import VARIATIONS, possible_robots
from tuning.gains.regional import (
    NONE,
    OWN,
    candidates,
    choose,
    legs_anywhere,
    legs_into,
    told,
)
from tuning.regions.cells import cells_of

ROBOT = exact(consistent())
KNOCKS = types.SimpleNamespace(
    x=np.array([0.6, 1.6]),
    y=np.array([0.4, 0.4]),
    pretension=np.full(2, 350.0),
    frequency=np.array([3.6, 3.5]),
    frequency_sigma=np.full(2, 0.01),
    damping_ratio=np.zeros(2),
)
CELLS = cells_of(KNOCKS, ROBOT, pretension=350.0)
ROBOTS = possible_robots(ROBOT)


@pytest.fixture(scope="module")
def into():
    legs = legs_into(CELLS, ROBOTS, count=10, seed=3)
    return legs, [outcome(part, plain_law()) for part in legs]


def chosen(into, controller, tried):
    return choose(CELLS, *into, controller, tried)


def test_legs_end_in_the_cell_that_they_are_for(into):
    for cell, legs in zip(CELLS, into[0], strict=True):
        assert all(cell.region.contains(*end, 350.0) for end in legs.end)


def test_under_the_plain_gains_nothing_that_is_chosen_is_worse_than_none(into):
    shapers = chosen(into, published_pd(), candidates(CELLS, Shaper([0.0], [1.0])))
    assert all(regional.share <= 1 for regional in shapers)


def test_a_shaper_that_shakes_isnt_chosen(into):
    # Half a period apart and of opposite signs, as bad as can be.
    tried = candidates(CELLS, Shaper([0.0, 0.14], [3.0, -2.0])).only((OWN, NONE))
    assert {regional.kind for regional in chosen(into, published_pd(), tried)} == {NONE}


def test_a_shaper_that_helps_is_chosen_before_none(into):
    own = Shaper([0.0, 0.3, 1.2], [0.57, 0.47, -0.04])
    tried = candidates(CELLS, own).only((NONE, OWN))
    for regional in chosen(into, PD(18.0, 0.75), tried):
        assert regional.kind == OWN
        np.testing.assert_array_equal(regional.shaper.times, own.times)


def test_every_kind_is_tried_at_the_cells_own_frequency():
    tried = candidates(CELLS, Shaper([0.0], [1.0])).only(("zv",))
    for cell, (shaper,) in zip(CELLS, tried.shapers, strict=True):
        assert shaper.times.size == IMPULSES
        assert float(shaper.times[1]) == pytest.approx(0.5 / cell.frequency)


def test_legs_anywhere_take_the_robots_in_turn():
    legs, inside = legs_anywhere(CELLS, ROBOTS, count=2 * len(ROBOTS), seed=1)
    tensions = legs.ensemble.robot.cable.effective_pretension
    scale = np.array([each.tension for each in VARIATIONS] * 2)
    per_cell = tensions / scale
    for cell in set(inside):
        of_cell = per_cell[np.array(inside) == cell]
        np.testing.assert_allclose(of_cell, of_cell[0])


def test_the_fitted_robot_is_the_first_that_is_possible():
    assert ROBOTS[0].drawn is ROBOT
    assert ROBOTS[0].variation == VARIATIONS[0]
    assert len(ROBOTS) == len(VARIATIONS)


def test_idle_impulses_change_no_leg(into):
    legs, before = into[0][0], into[1][0]
    law = plain_law()
    padded_law = type(law)(law.controller, padded(Shaper([0.0], [1.0]), IMPULSES))
    np.testing.assert_allclose(outcome(legs, padded_law).vibration, before.vibration, rtol=1e-9)


def test_regions_may_have_shapers_of_other_numbers_of_impulses(into):
    legs, _ = into
    shapers = Shaper(np.zeros(1), np.ones(1)), Shaper(np.array([0.0, 0.14]), np.full(2, 0.5))
    law = told(published_pd(), shapers, legs=[*map(len, legs)])
    first = len(legs[0])
    assert law.shaper.amplitudes.shape == (first + len(legs[1]), IMPULSES)
    assert law.shaper.amplitudes[0].tolist() == [1.0] + [0.0] * (IMPULSES - 1)
    assert law.shaper.times[first].tolist() == [0.0] + [0.14] * (IMPULSES - 1)
