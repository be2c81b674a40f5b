import itertools

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from tuning.codesign.search import scattered
from tuning.codesign.tail import descend, tail_of, value_at_risk

PLACES = np.array([0.0, 1.0, 1.5, 5.0])


def costs(point):
    return np.sum((point - PLACES[:, None]) ** 2, axis=1)


def linearised(point, rows):
    return point - PLACES[rows, None], np.ones((len(rows), 1, 1))


def test_the_value_at_risk_is_the_mean_of_the_worst_share():
    assert value_at_risk(np.array([3.0, 1.0, 2.0, 8.0]), 0.5) == 5.5


@hypothesis.given(st.lists(st.floats(0, 1e6), min_size=1, max_size=30), st.floats(0.01, 1.0))
def test_the_value_at_risk_lies_between_mean_and_largest(values, share):
    values = np.array(values)
    risk = value_at_risk(values, share)
    rounding = 64 * np.finfo(float).eps * max(values.max(), 1e-300)
    assert values.mean() - rounding <= risk <= values.max() + rounding


def test_all_models_give_the_mean_of_squares():
    found = descend(costs, linearised, np.array([9.0]), share=1.0, iterations=30, tolerance=0.0)
    np.testing.assert_allclose(found.point, PLACES.mean(), atol=1e-6)


def test_the_worst_model_alone_gives_the_middle_of_the_range():
    found = descend(
        costs, linearised, np.array([9.0]), share=0.25, iterations=60, tolerance=0.0
    )
    # At the kink the steps shrink and end: what is left is the last damping's.
    np.testing.assert_allclose(found.point, 2.5, atol=0.05)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_the_tails_mean_never_rises(share):
    history = descend(costs, linearised, np.array([-7.0]), share=share, iterations=20).history
    assert all(later <= before for before, later in itertools.pairwise(history))


def test_what_is_no_number_is_in_the_tail_and_never_better():
    assert list(tail_of(np.array([1.0, np.nan, 3.0]), 0.3)) == [1]

    def cliff(point):
        return np.where(point[0] < 4.0, np.nan, costs(point))

    found = descend(cliff, linearised, np.array([9.0]), share=1.0, iterations=20)
    assert found.point[0] >= 4.0


def test_scattered_rows_are_distinct_and_meet_every_pose():
    rows = scattered(960, 120)
    assert len(set(rows)) == len(rows) > 100
    assert set(rows % 20) == set(range(20))
