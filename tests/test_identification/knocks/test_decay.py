"""The sum of decaying sines: its derivatives, and exact recovery without noise."""

import numpy as np
import pytest

from identification.knocks.decay import fit_decay

TIME = np.sort(np.random.default_rng(4).uniform(0.0, 2.5, 75))
TIME[0] = 0.0
BAND = (0.6, 13.0)
MODES = np.array([[3.1, 0.4, 8.0, 2.0], [8.7, 1.5, 2.0, -3.0]])  # f [Hz], rate, cos, sin


def signal(modes, *, offset=4.0, drift=0.0):
    total = offset + drift * TIME
    for frequency, rate, cosine, sine in modes:
        phase = 2 * np.pi * frequency * TIME
        total = total + np.exp(-rate * TIME) * (cosine * np.cos(phase) + sine * np.sin(phase))
    return total


@pytest.mark.parametrize("drift", [0.0, -0.7])
@pytest.mark.parametrize("count", [1, 2])
def test_noise_free_modes_are_recovered_without_a_guess(count, drift):
    data = signal(MODES[:count], drift=drift)
    fit = fit_decay(TIME, data, band=BAND, drift=drift != 0)
    if count == 2:
        fit = fit_decay(TIME, data, band=BAND, drift=drift != 0, beside=fit)
    order = np.argsort(fit.angular_frequency)
    # The search stops where a step gains less than 1e-8 of the cost: 1e-4 of nothing.
    frequency = fit.angular_frequency[order] / (2 * np.pi)
    np.testing.assert_allclose(frequency, MODES[:count, 0], rtol=1e-6)
    np.testing.assert_allclose(fit.rate[order], MODES[:count, 1], rtol=1e-4)
    amplitude = np.hypot(MODES[:count, 2], MODES[:count, 3])
    np.testing.assert_allclose(fit.amplitude[order], amplitude, rtol=1e-5)


def test_the_covariance_from_the_jacobian_is_the_scatter_of_the_estimates():
    random, sigma = np.random.default_rng(8), 0.3
    fits = [
        fit_decay(
            TIME, signal(MODES[:1]) + sigma * random.normal(size=75), band=BAND, drift=False
        )
        for _ in range(60)
    ]
    jacobian = fits[0].jacobian
    claimed = sigma * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))[:2])
    found = np.std([[fit.angular_frequency[0], fit.rate[0]] for fit in fits], axis=0)
    # The standard deviation of 60 is good to 9 %: four of that, and what one fit's own
    # Jacobian differs from the true one's.
    np.testing.assert_allclose(found, claimed, rtol=0.4)
