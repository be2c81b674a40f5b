"""The shaper for a spectrum against what the spectrum's judge computes by itself."""

import itertools
import json
import pathlib

import numpy as np
import pytest

from tuning.shapers.catalogue import CATALOGUE, ei, mzv, zv
from tuning.shapers.comparison import fitted, pick
from tuning.shapers.design import least_duration, least_residual
from tuning.shapers.spectrum import DAMPING_RATIOS, Spectrum, vibration_left
from tuning.shapers.spectrum_design import design_for_spectrum
from tuning.shapers.spectrum_file import read_spectrum

PRINTERS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "klipper"
needs_printers = pytest.mark.skipif(not PRINTERS.is_dir(), reason="the spectra are absent")
PERIODS = {"zv": 0.5, "mzv": 0.75, "ei": 1.0, "2hump_ei": 1.5, "3hump_ei": 2.0}
PRINTED = 5e-7  # The reference prints per cent with four decimals.


def two_peaks():
    frequency = np.linspace(1.6, 200, 125)
    peaks = [1 / ((frequency / f - f / frequency) ** 2 + 0.03) for f in (41.0, 67.0)]
    power = peaks[0] + 0.4 * peaks[1]
    return Spectrum(frequency, power / power.max())


def judged(shaper, spectrum):
    """The judge's formula, written anew."""
    times, amplitudes = np.asarray(shaper.times), np.asarray(shaper.amplitudes)
    threshold, worst = spectrum.power.max() / 20, 0.0
    for ratio in DAMPING_RATIOS:
        omega = 2 * np.pi * spectrum.frequency[:, None]
        decay = np.exp(-ratio * omega * (times[-1] - times))
        turned = np.exp(1j * omega * np.sqrt(1 - ratio**2) * times)
        left = np.abs((amplitudes * decay * turned).sum(axis=1))
        kept = np.maximum(left * spectrum.power - threshold, 0).sum()
        worst = max(worst, kept / np.maximum(spectrum.power - threshold, 0).sum())
    return worst


@pytest.mark.parametrize("design", [zv, mzv, ei])
def test_vibration_left_is_what_its_formula_says(design):
    spectrum, shaper = two_peaks(), design(48.0, 0.1)
    assert abs(float(vibration_left(spectrum)(shaper)) - judged(shaper, spectrum)) <= 1e-12


def test_the_best_frequency_leaves_hardly_more_than_any_other():
    criterion, entry = vibration_left(two_peaks()), CATALOGUE[1]
    best = fitted(entry, criterion, damping_ratio=0.1)
    every = [float(criterion(entry.design(f, 0.1))) for f in np.linspace(25, 90, 131)]
    assert best.residual <= min(every) + 6e-4


@pytest.fixture(scope="module")
def design():
    return design_for_spectrum(two_peaks())


@pytest.mark.slow
def test_what_is_recommended_is_no_longer_and_leaves_no_more_than_the_catalogues(design):
    picked = pick([one.fit for one in design.compared])
    assert float(design.recommended.shaper.duration) <= float(picked.shaper.duration)
    assert judged(design.recommended.shaper, design.spectrum) <= picked.residual


@pytest.mark.slow
def test_no_shaper_of_the_catalogue_beats_its_optimised_counterparts(design):
    for one in design.compared:
        assert one.same_duration.residual <= one.fit.residual + 1e-8
        assert float(one.same_duration.shaper.duration) <= float(one.fit.shaper.duration) * (
            1 + 1e-12
        )
        assert one.same_vibration.residual <= one.fit.residual
        assert float(one.same_vibration.shaper.duration) <= float(one.fit.shaper.duration)


def test_no_design_of_the_front_is_beaten_by_another(design):
    each = [
        (float(one.shaper.duration), one.shaper.times.size, one.residual)
        for one in design.front
    ]
    for one, other in itertools.permutations(each, 2):
        assert any(a < b for a, b in zip(one, other, strict=True))
    assert each == sorted(each)
    assert each[-1][2] <= 1e-7


def test_with_as_many_impulses_longer_designs_of_the_front_leave_less(design):
    for count in {one.shaper.times.size for one in design.front}:
        same = [one.residual for one in design.front if one.shaper.times.size == count]
        assert same == sorted(same, reverse=True)


@pytest.mark.slow
@pytest.mark.parametrize("impulses", [2, 3])
def test_no_design_has_more_impulses_than_are_allowed(impulses):
    capped = design_for_spectrum(two_peaks(), impulses=impulses)
    designs = [capped.recommended, *capped.front]
    designs += [one.same_duration for one in capped.compared]
    designs += [one.same_vibration for one in capped.compared]
    assert max(one.shaper.times.size for one in designs) <= impulses


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [0.3, 4.0, 200.0])
@pytest.mark.parametrize("damping_ratio", [0.02, 0.06])
def test_a_single_clean_mode_needs_two_to_four_impulses(frequency, damping_ratio):
    at = frequency * np.linspace(0.01, 4.0, 400)
    ratio = at / frequency
    power = 1 / ((1 - ratio**2) ** 2 + (2 * damping_ratio * ratio) ** 2)
    best = design_for_spectrum(Spectrum(at, power / power.max())).recommended
    assert 2 <= best.shaper.times.size <= 4
    assert best.residual <= 0.05


def test_one_impulse_is_refused():
    with pytest.raises(ValueError, match="one impulse is no shaper"):
        design_for_spectrum(two_peaks(), impulses=1)


@needs_printers
@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(PRINTERS.glob("*.csv")), ids=lambda path: path.stem)
def test_printers_shake_no_more_and_wait_no_longer_than_with_the_reference(path):
    reference = json.loads((PRINTERS / "reference.json").read_text())["files"][path.name]
    spectrum = read_spectrum(path).spectrum
    criterion = vibration_left(spectrum)
    for name, known in reference["shapers"].items():
        duration = PERIODS[name] / known["freq"] / np.sqrt(1 - 0.1**2)
        bound = known["vibrations_pct"] / 100
        same = least_residual(criterion, duration=duration)
        assert judged(same.shaper, spectrum) <= bound + PRINTED
        assert float(same.shaper.duration) <= duration * (1 + 1e-12)
        shorter = least_duration(criterion, bound=bound + PRINTED)
        assert judged(shorter.shaper, spectrum) <= bound + PRINTED
        assert float(shorter.shaper.duration) <= duration
