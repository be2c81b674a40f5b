"""Errors of an axis's parameters: what horizons and halves disagree by is in them."""

import numpy as np

from identification.axis.errors import DISAGREEING, errors

SAMPLES = 4000


def fit(random, *, off):
    """A straight line seen by two horizons, the second of which is off by a slope."""
    time = np.linspace(-1.0, 1.0, SAMPLES)
    jacobian = np.stack([np.stack([np.ones(SAMPLES), time], axis=1)] * 2)
    measured = random.normal(size=(2, SAMPLES))
    measured[1] += off * time
    flat, all_measured = jacobian.reshape(-1, 2), measured.reshape(-1)
    values, *_ = np.linalg.lstsq(flat, all_measured, rcond=None)
    return values, (flat @ values - all_measured).reshape(2, -1), jacobian


def test_horizons_that_agree_widen_hardly_anything():
    random = np.random.default_rng(5)
    widths = []
    for _ in range(50):
        found = errors(*fit(random, off=0.0))
        widths.append(np.sqrt(found.covariance[1, 1]))
    # By noise alone the slope of 8000 samples is known to sqrt(3 / 8000).
    assert 0.9 < np.median(widths) / np.sqrt(3 / (2 * SAMPLES)) < 1.6


def test_horizons_that_disagree_widen_the_error_to_what_they_disagree_by():
    values, residuals, jacobian = fit(np.random.default_rng(6), off=2.0)
    found = errors(values, residuals, jacobian)
    assert 1.0 < np.sqrt(found.covariance[1, 1]) < 4.0
    assert np.sqrt(found.covariance[0, 0]) < 0.2


def test_halves_that_disagree_are_told_with_their_values():
    random = np.random.default_rng(7)
    level = np.where(np.arange(SAMPLES) < SAMPLES // 2, 1.0, 3.0)
    jacobian = np.ones((1, SAMPLES, 1))
    residuals = 2.0 - level - random.normal(size=SAMPLES)
    found = errors(np.array([2.0]), residuals[None], jacobian)
    first, second = (half.values[0] for half in found.halves)
    assert abs(first - 1.0) < 0.1
    assert abs(second - 3.0) < 0.1
    assert found.changes(0) > DISAGREEING
