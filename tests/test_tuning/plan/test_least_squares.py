import itertools

import numpy as np
import pytest

from tuning.plan.least_squares import least_squares


def rosenbrock(point):
    x, y = point
    residuals = np.array([10 * (y - x * x), 1 - x])
    return residuals, np.array([[-20 * x, 10.0], [-1.0, 0.0]])


@pytest.mark.parametrize("start", [(-1.2, 1.0), (2.0, -2.0), (0.0, 0.0)])
def test_rosenbrocks_valley_is_followed_to_its_end(start):
    found = least_squares(rosenbrock, np.array(start), iterations=100, tolerance=1e-12)
    np.testing.assert_allclose(found.point, 1.0, atol=1e-6)


def test_the_cost_never_rises():
    costs = [
        least_squares(rosenbrock, np.array([-1.2, 1.0]), iterations=n, tolerance=0.0).cost
        for n in range(12)
    ]
    assert all(later <= before for before, later in itertools.pairwise(costs))


def test_an_unknown_that_moves_nothing_stays_where_it_was():
    def blind(point):
        return point[:1] - 3.0, np.array([[1.0, 0.0]])

    found = least_squares(blind, np.array([0.0, 5.0]), iterations=50, tolerance=0.0)
    np.testing.assert_allclose(found.point, [3.0, 5.0], atol=1e-6)


def test_a_residual_that_is_not_finite_is_never_taken_for_better():
    def cliff(point):
        residuals = np.where(point > 1.0, np.nan, point - 2.0)
        return residuals, np.ones((1, 1))

    found = least_squares(cliff, np.array([0.0]), iterations=20)
    assert found.point[0] <= 1.0
    assert np.isfinite(found.cost)
