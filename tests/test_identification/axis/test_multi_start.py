"""The search by gradients and the search without them, on problems with known minima."""

import numpy as np
import pytest

from identification.axis.multi_start import minimise
from identification.axis.pattern_search import polish

FREE = np.array([-np.inf, -np.inf])


def rosenbrock(points):
    x, y = points[:, 0], points[:, 1]
    residuals = np.stack([10 * (y - x**2), 1 - x], axis=1)
    ones, zeros = np.ones_like(x), np.zeros_like(x)
    rows = [np.stack([-20 * x, 10 * ones], axis=1), np.stack([-ones, zeros], axis=1)]
    return residuals, np.stack(rows, axis=1)


def distance(points):
    """Distance from (1, -1), with a third residual so that none can be 0."""
    target = np.array([1.0, -1.0])
    residuals = np.concatenate([points - target, np.ones((len(points), 1))], axis=1)
    jacobian = np.broadcast_to(
        np.concatenate([np.eye(2), np.zeros((1, 2))]), (len(points), 3, 2)
    )
    return residuals, np.array(jacobian)


def kinked(points):
    """Residuals with a ridge along x = y, so that the minimum (1, 1) lies on a kink."""
    x, y = points[:, 0], points[:, 1]
    residuals = np.stack([1 + 5 * np.abs(x - y), x + y - 2.0], axis=1)
    sign = 5 * np.sign(x - y)
    ones = np.ones_like(x)
    rows = [np.stack([sign, -sign], axis=1), np.stack([ones, ones], axis=1)]
    return residuals, np.stack(rows, axis=1)


def costs(problem):
    return lambda points: 0.5 * np.sum(problem(points)[0] ** 2, axis=1)


def test_the_curved_valley_is_followed_to_its_end():
    minimum = minimise(rosenbrock, np.array([[-1.2, 1.0]]), lower=FREE, max_iterations=60)
    # A cost of 1e-10 of itself is a residual of rounding: ten digits are asked for.
    np.testing.assert_allclose(minimum.parameters, [1.0, 1.0], atol=1e-10)


def test_the_best_of_several_starts_wins():
    starts = np.array([[np.nan, 0.0], [5.0, 5.0], [-1.2, 1.0]])
    minimum = minimise(rosenbrock, starts, lower=FREE, max_iterations=60)
    assert minimum.costs[0] == np.inf
    assert 0.5 * minimum.residuals @ minimum.residuals == np.min(minimum.costs)


def test_a_parameter_rests_at_its_bound_and_the_others_go_on():
    lower = np.array([-np.inf, 0.0])
    minimum = minimise(distance, np.array([[4.0, 3.0]]), lower=lower)
    assert minimum.parameters[1] == 0.0
    # Marquardt's damping leaves a thousandth of each step over, ten times less each time.
    assert minimum.parameters[0] == pytest.approx(1.0, abs=1e-6)


def test_starts_that_are_all_impossible_are_an_error():
    with pytest.raises(ValueError, match="finite at none of the 1 starts"):
        minimise(rosenbrock, np.array([[np.inf, 0.0]]), lower=FREE)


def test_a_minimum_on_a_kink_is_found_without_a_gradient():
    start = np.array([3.0, -2.0])
    polished = polish(kinked, costs(kinked), start, lower=FREE)
    assert polished.converged
    # Steps end at 2 % of a standard error, residuals' norm over the root of 2 samples.
    np.testing.assert_allclose(polished.parameters, [1.0, 1.0], atol=0.02)


def test_the_search_without_a_gradient_keeps_to_the_bounds():
    lower = np.array([-np.inf, 0.0])
    polished = polish(distance, costs(distance), np.array([4.0, 3.0]), lower=lower)
    assert polished.parameters[1] == 0.0
    assert polished.parameters[0] == pytest.approx(1.0, abs=0.02)
