"""Reading spectra: what is meant is read, what isn't one is refused with one message."""

import numpy as np
import pytest

from tuning.shapers.spectrum_file import read_spectrum

FREQUENCY = np.arange(0.0, 40.0, 2.0)
DENSITY = FREQUENCY * (1 + 9 * np.exp(-((FREQUENCY - 20) ** 2) / 20))


def text(header="freq,psd_x,psd_y,psd_z,psd_xyz", rows=None):
    lines = [f"{f},{d},1,2,{d + 3}" for f, d in zip(FREQUENCY, DENSITY, strict=True)]
    return "\n".join([header, *(lines if rows is None else rows)]) + "\n"


@pytest.fixture
def write(tmp_path):
    def written(content):
        path = tmp_path / "spectrum.csv"
        path.write_text(content, encoding="utf-8")
        return path

    return written


def test_the_spectrum_is_the_total_density_over_the_frequency(write):
    read = read_spectrum(write(text()))
    expected = (DENSITY[1:] + 3) / FREQUENCY[1:]
    assert read.column == "psd_xyz"
    assert not read.was_normalised
    assert np.allclose(read.spectrum.power, expected / expected.max(), rtol=1e-14)
    assert read.spectrum.frequency[0] == 2.0


def test_columns_of_shapers_mean_that_the_densities_are_normalised(write):
    rows = [f"{f},{d},1.0" for f, d in zip(FREQUENCY, DENSITY, strict=True)]
    read = read_spectrum(write(text("freq,psd_xyz,mzv(48.4)", rows)))
    assert read.was_normalised
    assert np.allclose(read.spectrum.power, DENSITY[1:] / DENSITY.max(), rtol=1e-14)


def test_without_a_total_the_densities_are_added(write):
    rows = [f"{f},{d},1" for f, d in zip(FREQUENCY, DENSITY, strict=True)]
    read = read_spectrum(write(text("frequency [Hz],psd_x,psd_y", rows)), normalised=True)
    expected = DENSITY[1:] + 1
    assert read.column == "psd_x + psd_y"
    assert np.allclose(read.spectrum.power, expected / expected.max(), rtol=1e-14)


def test_a_named_column_is_taken(write):
    assert read_spectrum(write(text()), column="psd_x").column == "psd_x"


def test_low_frequencies_are_left_out_where_asked(write):
    assert read_spectrum(write(text()), lowest=9.0).spectrum.frequency[0] == 10.0


BROKEN = text().replace("\n4.0,", "\n4.0,x").replace("\n8.0,", "\n-8.0,")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", r"spectrum.csv: got an empty file, expected a header .* Export"),
        ("t,ax\n0,1\n", r"row 1: 0 columns of frequency, got 't,ax', expected one .* Rename"),
        (
            text("freq,a,b,c,d"),
            r"row 1: no column 'psd…', got 'freq,a,b,c,d', expected .* Name",
        ),
        (BROKEN, r"row 4, column 'psd_xyz'|row 4: got|row 6, column 'freq': got '-8.0'"),
        (text() + "50,1\n", r"row 22: 2 cells, expected 5, expected finite numbers"),
        (text() + "1,1,1,1,1\n", r"row 22, column 'freq': got 1 after 38, expected .* Sort"),
        (text(rows=["1,1,1,1,1"]), r"got 1 bins .* expected at least 8 .* Record"),
        (text(rows=[f"{f},0,0,0,0" for f in FREQUENCY]), r"highest density 0, .* Record"),
    ],
)
def test_what_is_no_spectrum_is_refused_with_one_message(write, content, message):
    with pytest.raises(ValueError, match=message):
        read_spectrum(write(content))


def test_an_unknown_column_is_refused(write):
    with pytest.raises(ValueError, match=r"no column 'psd_q', got .* Name the column"):
        read_spectrum(write(text()), column="psd_q")
