"""Spectra of other people's files: each is read right or refused with the right remedy."""

import pathlib

import pytest

from tuning.shapers.catalogue import three_hump_ei
from tuning.shapers.spectrum import Spectrum, vibration_left
from tuning.shapers.spectrum_design import design_for_spectrum
from tuning.shapers.spectrum_file import read_spectrum

CASES = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "cases"
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the shared cases are absent")


@pytest.mark.parametrize("name", ["s_hz", "s_rad", "s_khz"])
def test_a_spectrum_peaks_where_it_does_in_any_unit(name):
    file = read_spectrum(CASES / "spectrum-unit-ignored" / f"{name}.csv")
    assert file.spectrum.peak == pytest.approx(45.0, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["s_hz", "s_rad", "s_khz"])
def test_its_shaper_has_two_impulses_in_any_unit(name):
    spectrum = read_spectrum(CASES / "spectrum-unit-ignored" / f"{name}.csv").spectrum
    best = design_for_spectrum(spectrum).recommended.shaper
    assert best.times.size == 2
    assert 1e3 * float(best.duration) == pytest.approx(11.2, abs=0.05)


@pytest.mark.parametrize("name", ["s_multi", "s_multi2"])
def test_a_shaper_is_judged_by_the_sensor_at_which_it_leaves_most(name):
    spectrum = read_spectrum(CASES / "spectrum-several-sensors" / f"{name}.csv").spectrum
    shaper = three_hump_ei(48.0, 0.1)
    left = float(vibration_left(spectrum)(shaper))
    each = [
        float(vibration_left(Spectrum(spectrum.frequency, power))(shaper))
        for power in spectrum.power
    ]
    assert spectrum.peaks == pytest.approx((45.0, 22.5))
    assert left == pytest.approx(max(each), rel=1e-12)
    # What the tool of the file's own program says of it.
    assert left == pytest.approx(0.022, abs=5e-4)


def test_a_german_spreadsheets_separators_are_named():
    with pytest.raises(ValueError, match=r"the separator is ';' and the decimal point ','"):
        read_spectrum(CASES / "spectrum-semicolon" / "s_semi.csv")
