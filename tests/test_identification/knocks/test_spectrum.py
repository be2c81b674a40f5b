"""Spectrum and peak picking on sines of known frequency and amplitude."""

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from identification.knocks.spectrum import amplitude_spectrum, natural_frequency


def camera(seed=0, *, duration=3.0, rate=30.0, jitter=2e-3):
    """Sample times of a camera that isn't quite even."""
    time = np.arange(0.0, duration, 1 / rate)
    return time + np.random.default_rng(seed).uniform(-jitter, jitter, len(time))


def test_a_sine_shows_its_amplitude_at_its_frequency():
    time = np.arange(0.0, 4.0, 1 / 50)
    # Eight whole periods: no leakage from the mean, the peak stands on a bin.
    frequency, amplitude = amplitude_spectrum(time, 5.0 + 0.3 * np.sin(2 * np.pi * 2.0 * time))
    top = np.argmax(amplitude)
    # The peak's own mirror image at -2 Hz leaks in by 1/(2 pi 2 f T) = 1 %.
    assert amplitude[top] == pytest.approx(0.3, rel=0.02)
    assert frequency[top] == pytest.approx(2.0, abs=frequency[1])


def test_the_mean_is_removed():
    time = camera()
    one = amplitude_spectrum(time, np.sin(20 * time))
    other = amplitude_spectrum(time, np.sin(20 * time) + 1e3)
    # Interpolating about a mean of 1e3 rounds at 1e3 eps.
    np.testing.assert_allclose(one[1], other[1], atol=1e-10)


@hypothesis.given(
    st.floats(1.5, 6.0), st.floats(0.0, 2 * np.pi), st.integers(0, 5), st.floats(0.5, 30.0)
)
def test_the_peak_lies_within_a_tenth_of_the_resolution(frequency, phase, seed, amplitude):
    time = camera(seed)
    signal = amplitude * np.cos(2 * np.pi * frequency * time + phase)
    # Ten frames lost in one go and three single ones.
    signal[40:50] = np.nan
    signal[[5, 20, 70]] = np.nan
    peak = natural_frequency(time, signal)
    # The mirror image's leakage of 1/(4 pi f T) = 2 % at the lowest, and the mean's, shift
    # the peak of a main lobe by no more than some hundredths of its half-width, and the
    # gap bends the sine at the highest.
    assert abs(peak.frequency - frequency) < 0.15 * peak.resolution


def test_the_resolution_is_the_reciprocal_length_of_the_record():
    time = camera()
    peak = natural_frequency(time, np.sin(20 * time))
    assert peak.resolution == pytest.approx(1 / (time[-1] - time[0]))


def test_two_modes_closer_than_the_resolution_are_one_peak_and_further_apart_are_two():
    time = camera(duration=4.0)

    def peaks(apart):
        waves = np.sin(2 * np.pi * 3.0 * time) + np.sin(2 * np.pi * (3.0 + apart) * time)
        frequency, amplitude = amplitude_spectrum(time, waves)
        inner = amplitude[1:-1]
        tops = (inner > amplitude[:-2]) & (inner > amplitude[2:]) & (inner > 0.5)
        return np.sum(tops & (frequency[1:-1] > 2))

    assert peaks(0.4 / 4.0) == 1
    assert peaks(2.5 / 4.0) == 2


def test_a_signal_that_stands_still_has_no_peak():
    with pytest.raises(ValueError, match=r"spectrum of 3\.5 s has no peak above 0\.429 Hz"):
        natural_frequency(np.arange(8.0) / 2, np.ones(8))


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError, match="7 samples with a position, expected at least 8"):
        amplitude_spectrum(np.arange(9.0), np.array([np.nan, np.nan, *range(7)]))
