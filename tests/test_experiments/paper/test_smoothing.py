"""What smoothed friction does to a fit, on one short run."""

import numpy as np
import pytest

from experiments.paper.topics.smoothing.figure import draw_smoothing
from experiments.paper.topics.smoothing.numbers import (
    AT_TRUTH,
    STEPS,
    WIDTHS,
    Errors,
    Motion,
    Pulls,
    Smoothing,
    bias,
    difference_error,
    exact_model,
    gradient_error,
    smooth_model,
)
from scdpr_jax.robot.parameters import SMOOTHING_WIDTH
from scdpr_jax.robot.state import carriages

PULL = Pulls(np.array([[0.5, 0.4]]), np.array([6.0]), pulled=0.2, length=1.0)
EXACT = exact_model(PULL, step=5e-3)


@pytest.fixture(scope="module")
def truth():
    return EXACT(AT_TRUTH)


@pytest.fixture(scope="module")
def wide_and_narrow():
    return [smooth_model(PULL, width=width) for width in (1e-2, 1e-3)]


def test_run_ends_where_friction_holds_the_carriages(truth):
    last = carriages(truth.position[0, -5:])
    assert np.all(last == last[0])


@pytest.mark.slow
def test_bias_falls_with_the_width(wide_and_narrow, truth):
    wide, narrow = (np.abs(bias(model, truth.position)) for model in wide_and_narrow)
    # In proportion; the time to stop adds a logarithm of the width.
    assert wide[0] > 4 * narrow[0] > 0


def test_exact_engine_finds_its_own_unknowns(truth):
    # The fit's end: a ten-thousandth of one frame's noise.
    assert np.abs(bias(EXACT, truth.position)).max() <= 1e-6


def test_exact_derivatives_are_central_differences():
    assert difference_error(EXACT) <= 1e-5


def test_derivatives_that_are_a_hundredth_off_are_told_from_differences():
    def off(logs):
        found = EXACT(logs)
        return found._replace(derivative=1.01 * found.derivative)

    assert difference_error(off) == pytest.approx(0.01 / 1.01, rel=1e-2)


@pytest.mark.slow
def test_derivative_where_carriages_are_held_approaches_the_exact_one(wide_and_narrow, truth):
    wide, narrow = (
        gradient_error(model(AT_TRUTH), truth, frame=-1) for model in wide_and_narrow
    )
    assert wide > 4 * narrow > 0


def test_error_of_a_gradient_is_a_share_of_it(truth):
    half_more = truth._replace(derivative=1.5 * truth.derivative)
    assert gradient_error(half_more, truth, frame=-1) == pytest.approx(0.5)
    assert gradient_error(truth, truth, frame=-1) == 0


def test_fit_that_does_not_converge_has_no_estimate(truth):
    def uphill(logs):
        found = EXACT(logs)
        return Motion(found.position, -found.derivative, found.steps)

    assert np.all(np.isnan(bias(uphill, truth.position)))


def proportional(slope):
    by_width = tuple(
        Errors(slope * width * np.array([1.0, -0.1, 0.2, -0.1]), width, 10 * width, 1 / width)
        for width in WIDTHS
    )
    exact = tuple(Errors(np.full(4, 1e-9), 0.0, 0.0, 1 / step) for step in STEPS)
    return Smoothing(by_width, exact, 0.0)


def test_power_of_a_proportional_bias_is_one():
    assert proportional(2.0).order == pytest.approx(1.0)


def test_wanted_width_is_where_the_bias_is_what_is_wanted():
    assert proportional(2.0).width_for_wanted == pytest.approx(0.5e-3)


def test_default_width_is_among_those_compared():
    assert proportional(2.0).default.sliding == pytest.approx(SMOOTHING_WIDTH)


def test_both_panels_mark_the_default_width_and_have_units():
    for axes in draw_smoothing(proportional(2.0)).axes:
        assert "[m/s]" in axes.get_xlabel()
        assert axes.get_ylabel().endswith("]")
        assert [text.xy[0] for text in axes.texts] == [SMOOTHING_WIDTH]
        assert axes.get_xscale() == axes.get_yscale() == "log"
