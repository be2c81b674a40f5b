"""A ring-down of a long fast record is that of all its samples."""

import numpy as np
import pytest
import scipy.stats

from identification.knocks import decimation
from identification.knocks.decimation import thinned
from identification.knocks.ring_down import ring_down

NOISE = 0.19e-3


def record(seed, *, rate, duration=4.5, second=8.7):
    random = np.random.default_rng(seed)
    time = np.arange(round(rate * duration)) / rate
    time += random.uniform(-0.05, 0.05, time.size) / rate
    x = NOISE * random.normal(size=time.size)
    for frequency, ratio, size in ((3.1, 0.01, 5e-3), (second, 0.02, 1e-3)):
        omega = 2 * np.pi * frequency
        damped = np.sqrt(1 - ratio**2) * omega
        x += size * np.exp(-ratio * omega * time) * np.cos(damped * time + random.uniform(0, 6))
    return time, x


def fit(time, x):
    return ring_down(time, x, noise_sigma=NOISE, after=0.0)


def test_it_finds_what_the_whole_record_tells(monkeypatch):
    time, x = record(0, rate=300)
    assert thinned(time, x / NOISE).together == 2
    few = fit(time, x)
    monkeypatch.setattr(decimation, "FEWEST", len(time) + 1)
    every = fit(time, x)
    assert len(few.modes) == len(every.modes) == 2
    for own, other in zip(few.modes, every.modes, strict=True):
        # Means lose a per cent of what is known: the estimates differ by a tenth of an error.
        assert abs(own.frequency - other.frequency) < 0.3 * other.frequency_sigma
        assert abs(own.damping_ratio - other.damping_ratio) < 0.3 * other.damping_ratio_sigma
        assert own.frequency_sigma == pytest.approx(other.frequency_sigma, rel=0.05)
        assert own.damping_ratio_sigma == pytest.approx(other.damping_ratio_sigma, rel=0.05)
        assert own.amplitude == pytest.approx(other.amplitude, abs=NOISE / 5)


def test_a_record_of_three_kilohertz_tells_what_it_is_made_of():
    time, x = record(1, rate=3000)
    means = thinned(time, x / NOISE)
    assert len(means.time) >= decimation.FEWEST
    decay = fit(time, x)
    assert decay.residuals_are_noise
    for mode, (frequency, ratio) in zip(decay.modes, ((3.1, 0.01), (8.7, 0.02)), strict=True):
        assert abs(mode.frequency - frequency) < 4 * mode.frequency_sigma
        assert abs(mode.damping_ratio - ratio) < 4 * mode.damping_ratio_sigma
    assert decay.amplitude == pytest.approx(5e-3, rel=0.01)


@pytest.mark.slow
def test_its_intervals_cover_the_truth_as_often_as_they_say():
    decays = [fit(*record(seed, rate=1000)) for seed in range(40)]
    covered = sum(abs(d.frequency - 3.1) <= 1.96 * d.frequency_sigma for d in decays)
    low, high = scipy.stats.binom.ppf([0.001, 0.999], len(decays), 0.95)
    assert low <= covered <= high


@pytest.mark.slow
def test_a_fast_vibration_keeps_its_samples():
    time, x = record(2, rate=3000, second=60.0, duration=2.5)
    means = thinned(time, x / NOISE)
    assert 1 <= means.together <= 3000 / (60 * decimation.A_PERIOD)
    assert [round(mode.frequency) for mode in fit(time, x).modes] == [3, 60]


def test_means_across_a_gap_do_not_count():
    time, x = record(3, rate=3000)
    kept = np.abs(time - 2.0) > 0.1
    means = thinned(time[kept], x[kept])
    assert not np.any(np.abs(means.time - 2.0) < 0.099)


def test_a_short_record_stays_as_it_is():
    time, x = record(4, rate=100)
    means = thinned(time, x)
    assert means.together == 1
    np.testing.assert_array_equal(means.signal, x)
    assert means.amplitude(3.1) == pytest.approx(1.0)
