import numpy as np
import pytest

from identification.fit.levenberg_marquardt import (
    Normal,
    free_unknowns,
    minimise,
    minimise_together,
)


def normal(residual, jacobian):
    return Normal(float(residual @ residual), jacobian.T @ residual, jacobian.T @ jacobian)


def rosenbrock(point):
    x, y = point
    residual = np.array([10 * (y - x**2), 1 - x])
    return normal(residual, np.array([[-20 * x, 10.0], [-1.0, 0.0]]))


NO_BOUND = np.full(2, -np.inf)


def test_it_walks_down_a_curved_valley_to_the_minimum():
    found = minimise(
        rosenbrock, np.array([-1.2, 1.0]), lower=NO_BOUND, iterations=60, decrement=1e-16
    )
    # The stopping rule allows a decrement of 1e-16; the slope of the valley is 1e-2 at most.
    np.testing.assert_allclose(found.point, [1.0, 1.0], atol=1e-6)
    assert found.ended == "converged"


def test_a_linear_problem_is_solved_at_once():
    matrix = np.array([[2.0, 1.0], [0.0, 3.0], [1.0, 1.0]])
    target = np.array([1.0, -2.0, 0.5])
    found = minimise(
        lambda x: normal(matrix @ x - target, matrix),
        np.zeros(2),
        lower=NO_BOUND,
        iterations=10,
        decrement=1e-12,
    )
    expected = np.linalg.lstsq(matrix, target, rcond=None)[0]
    # It may stop a millionth of the cost above the minimum, in a valley of curvature >= 1.
    np.testing.assert_allclose(found.point, expected, atol=np.sqrt(1e-6 * found.normal.cost))


def test_a_bound_holds_what_would_cross_it():
    found = minimise(
        lambda x: normal(x - np.array([-1.0, 2.0]), np.eye(2)),
        np.array([1.0, 1.0]),
        lower=np.array([0.0, -np.inf]),
        iterations=30,
        decrement=1e-12,
    )
    assert found.point[0] == 0.0
    # A millionth of the cost, 1, is left over at most.
    np.testing.assert_allclose(found.point[1], 2.0, atol=1e-3)
    free = free_unknowns(found.normal, found.point, np.array([0.0, -np.inf]))
    np.testing.assert_array_equal(free, [False, True])


def test_what_no_residual_depends_on_stays_where_it_was():
    found = minimise(
        lambda x: normal(np.array([x[0] - 3.0]), np.array([[1.0, 0.0]])),
        np.array([0.0, 7.0]),
        lower=NO_BOUND,
        iterations=20,
        decrement=1e-12,
    )
    assert found.point[1] == 7.0


def test_a_simulation_that_diverges_is_not_accepted():
    def evaluate(point):
        if point[0] > 1.5:
            return Normal(float("nan"), np.zeros(1), np.eye(1))
        return normal(np.array([point[0] - 2.0]), np.eye(1))

    found = minimise(
        evaluate, np.array([0.0]), lower=np.array([-np.inf]), iterations=60, decrement=1e-9
    )
    assert found.point[0] <= 1.5
    assert np.isfinite(found.normal.cost)
    assert found.ended == "stalled"


@pytest.mark.parametrize("iterations", [1, 3])
def test_running_out_of_iterations_is_said(iterations):
    found = minimise(
        rosenbrock, np.array([-1.2, 1.0]), lower=NO_BOUND, iterations=iterations, decrement=1e-9
    )
    assert found.ended == "unfinished"


def test_starts_that_go_together_end_where_each_would_alone():
    starts = [np.array([-1.2, 1.0]), np.array([2.0, -1.0]), np.array([0.0, 0.0])]
    options = {"lower": NO_BOUND, "iterations": 60, "decrement": 1e-16}
    together = minimise_together(
        lambda points: [rosenbrock(point) for point in points], starts, **options
    )
    for start, found in zip(starts, together, strict=True):
        alone = minimise(rosenbrock, start, **options)
        np.testing.assert_array_equal(found.point, alone.point)
        assert (found.iterations, found.ended) == (alone.iterations, alone.ended)
