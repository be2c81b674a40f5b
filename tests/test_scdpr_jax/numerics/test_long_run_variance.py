"""The robust covariance against known ones, and its intervals against the truth."""

import numpy as np
import pytest
import scipy.signal
import scipy.stats

from scdpr_jax.numerics.long_run_variance import sandwich

RECORDS = 200


def line(samples):
    time = np.linspace(-1.0, 1.0, samples)
    return np.stack([np.ones(samples), time], axis=1)


def covered(memory, *, samples=400, robust=True):
    """How many 95 % intervals of a line's slope hold the true one, 0."""
    random, jacobian = np.random.default_rng(3), line(samples)
    inside = 0
    for _ in range(RECORDS):
        # The filter's first samples are let pass: the noise is then stationary.
        noise = scipy.signal.lfilter([1.0], [1.0, -memory], random.normal(size=samples + 300))
        estimate, *_ = np.linalg.lstsq(jacobian, noise[300:], rcond=None)
        residuals = jacobian @ estimate - noise[300:]
        white = np.linalg.inv(jacobian.T @ jacobian) * np.var(residuals)
        covariance = sandwich(jacobian, residuals).covariance if robust else white
        inside += abs(estimate[1]) <= 1.96 * np.sqrt(covariance[1, 1])
    return inside


# From 95 % down to what a record of 13 correlation lengths allows (memory 0.9: 400 samples
# are some 21 independent ones), each with the binomial 0.1 % quantile below.
@pytest.mark.parametrize(("memory", "level"), [(0.0, 0.93), (0.6, 0.91), (0.9, 0.87)])
def test_intervals_cover_the_truth_under_correlated_noise(memory, level):
    assert covered(memory) >= scipy.stats.binom.ppf(0.001, RECORDS, level)


def test_the_usual_covariance_does_not_cover_under_correlated_noise():
    assert covered(0.9, robust=False) < scipy.stats.binom.ppf(0.001, RECORDS, 0.87)


def test_white_noise_gives_the_usual_covariance():
    random, jacobian = np.random.default_rng(0), line(20_000)
    residuals = random.normal(size=20_000)
    covariance = sandwich(jacobian, residuals).covariance
    expected = np.linalg.inv(jacobian.T @ jacobian)
    # Squares of 2e4 scores are good to 1 %, to 2 % in windows of a few samples, and the
    # critical value's growth adds less than 1 %: five times all of it.
    np.testing.assert_allclose(np.diag(covariance), np.diag(expected), rtol=0.1)


def test_scaling_a_parameter_scales_its_standard_error():
    random, jacobian = np.random.default_rng(1), line(300)
    residuals = random.normal(size=300)
    one = sandwich(jacobian, residuals).covariance
    other = sandwich(jacobian * np.array([1e6, 1e-6]), residuals).covariance
    np.testing.assert_allclose(
        np.diag(other), np.diag(one) * np.array([1e-12, 1e12]), rtol=1e-9
    )


def test_what_nothing_determines_gets_a_huge_standard_error():
    random = np.random.default_rng(2)
    jacobian = np.ones((300, 2))
    covariance = sandwich(jacobian, random.normal(size=300)).covariance
    assert np.all(np.isfinite(covariance))
    # One alone would be known to 1/sqrt(300) = 0.06.
    assert np.all(np.diag(covariance) > 1e3)
