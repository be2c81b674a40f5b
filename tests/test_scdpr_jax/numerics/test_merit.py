"""Merits are sums whose gradient and matrix are those of their residuals."""

import numpy as np

from scdpr_jax.numerics.merit import Normal, SumOfSquares

RESIDUALS = np.array([1.0, -2.0, 0.5])
JACOBIAN = np.array([[1.0, 0.0], [2.0, -1.0], [0.0, 4.0]])


def test_the_gradient_is_half_the_sums():
    step = 1e-6 * np.array([0.3, -0.8])
    moved = RESIDUALS + JACOBIAN @ step
    merit = SumOfSquares(RESIDUALS, JACOBIAN)
    # Of second order in the step: 1e-11 beside 1e-6.
    assert abs(moved @ moved - merit.cost - 2 * merit.gradient @ step) < 1e-10
    np.testing.assert_array_equal(merit.matrix, JACOBIAN.T @ JACOBIAN)


def test_residuals_that_are_no_numbers_have_no_merit():
    assert SumOfSquares(np.array([1.0, np.nan, 0.0]), JACOBIAN).cost == np.inf
    assert SumOfSquares(RESIDUALS, np.full((3, 2), np.inf)).cost == np.inf


def test_two_misfits_together_are_one_of_all_residuals():
    def normal(rows):
        merit = SumOfSquares(RESIDUALS[rows], JACOBIAN[rows])
        return Normal(merit.cost, merit.gradient, merit.matrix)

    both = normal(slice(0, 2)).plus(normal(slice(2, 3)))
    whole = SumOfSquares(RESIDUALS, JACOBIAN)
    assert both.cost == whole.cost
    np.testing.assert_array_equal(both.gradient, whole.gradient)
    np.testing.assert_array_equal(both.matrix, whole.matrix)
