"""The search without gradients, on problems with known minima."""

import numpy as np
import pytest

from identification.axis.pattern_search import polish

FREE = np.array([-np.inf, -np.inf])


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
