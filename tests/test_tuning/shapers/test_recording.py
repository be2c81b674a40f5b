import pathlib

import numpy as np
import pytest

from tuning.shapers.recording import spectrum_of_recording

PATH = pathlib.Path("shaken.csv")


def shaken(frequency, *, seconds=20.0, rate=800.0, jitter=0.0, seed=1):
    """A lightly damped machine under white noise: its response in one direction."""
    random = np.random.default_rng(seed)
    omega, ratio, step = 2 * np.pi * frequency, 0.03, 1 / rate
    time = np.arange(0, seconds, step)
    impulse = np.exp(-ratio * omega * time) * np.sin(omega * time)
    response = np.convolve(random.normal(size=len(time)), impulse)[: len(time)]
    stamps = time + jitter * step * random.uniform(-0.5, 0.5, len(time))
    return stamps, np.interp(stamps, time, response), random.normal(0, 0.3, len(time))


@pytest.mark.parametrize("frequency", [7.3, 41.0])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_the_peak_is_where_the_machine_vibrates(frequency, jitter):
    time, along, across = shaken(frequency, jitter=jitter)
    file = spectrum_of_recording(PATH, time, {"x": along, "y": across}, normalised=True)
    # A peak of 6 % width under noise wanders by a part of it.
    assert abs(file.spectrum.peak / frequency - 1) < 0.03
    assert any("Welch" in note for note in file.notes)
    assert any("can't know" in note for note in file.notes)


def test_a_force_that_grows_with_the_frequency_is_divided_out():
    time, along, _ = shaken(41.0)
    alike = spectrum_of_recording(PATH, time, {"x": along}, normalised=True).spectrum
    grown = spectrum_of_recording(PATH, time, {"x": along}).spectrum
    ratio = grown.power * alike.frequency / alike.power
    assert np.ptp(ratio) < 1e-9 * ratio.max()


def test_a_recording_that_is_too_short_is_refused():
    time, along, _ = shaken(41.0, seconds=0.2)
    with pytest.raises(ValueError, match="a recording of 160 samples"):
        spectrum_of_recording(PATH, time, {"x": along})


def test_a_recording_in_which_nothing_shakes_is_refused():
    time = np.arange(0, 5, 1e-3)
    with pytest.raises(ValueError, match=r"0 bins of .* with vibration"):
        spectrum_of_recording(PATH, time, {"x": np.zeros(len(time))})
