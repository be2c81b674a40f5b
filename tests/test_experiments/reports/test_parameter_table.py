"""A parameter's line says no more than its interval does."""

import pytest

from experiments.reports.parameter_table import parameter_row
from identification.judge.uncertainty import ParameterEstimate


def estimate(value, sigma, **others):
    given = {
        "name": "drive_friction",
        "setting": None,
        "unit": "N m",
        "interval95": (max(value - 1.96 * sigma, 0.0), value + 1.96 * sigma),
        "status": "identified",
    }
    return ParameterEstimate(value=value, sigma=sigma, **(given | others))


@pytest.mark.parametrize(
    ("value", "sigma", "told"),
    [
        (0.02, 1e-4, "0.98 %"),
        (1e-6, 1e-6, "> 100 %"),
        (0.0, 1e-6, "> 100 %"),
        (-0.02, 1e-4, "0.98 %"),
    ],
)
def test_what_may_be_zero_is_not_told_to_a_share_of_something_else(value, sigma, told):
    assert parameter_row(estimate(value, sigma)).relative == told


def test_what_no_run_shows_and_what_is_fixed_have_no_width():
    assert parameter_row(estimate(0.02, float("inf"))).relative == ""
    assert parameter_row(estimate(0.02, 0.0, status="fixed")).relative == ""
