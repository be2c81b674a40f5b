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


TWO = FREQUENCY * (1 + 9 * np.exp(-((FREQUENCY - 10) ** 2) / 20))


def sensors(header="freq,adxl345 hotend,adxl345 bed"):
    rows = [f"{f},{a},{b}" for f, a, b in zip(FREQUENCY, DENSITY, TWO, strict=True)]
    return text(header, rows)


@pytest.mark.parametrize(
    "header",
    [
        "freq,adxl345 hotend,adxl345 bed",
        'freq,"adxl345, hotend",adxl345 bed',
        "freq,psd_xyz hotend,psd_xyz bed",
        "freq,psd_xyz,psd_xyz",
    ],
)
def test_several_sensors_are_kept_apart(write, header):
    read = read_spectrum(write(sensors(header)))
    assert read.spectrum.peaks == (20.0, 10.0)
    assert "2 sensors, the worst of which counts" in read.notes[1]


def test_an_axis_twice_is_refused(write):
    with pytest.raises(ValueError, match=r"row 1: an axis twice, .* Give each sensor's"):
        read_spectrum(write(sensors("freq,psd_x,psd_x")))


def test_axes_in_two_units_are_refused(write):
    with pytest.raises(ValueError, match=r"row 1: axes in several units, .* Convert them"):
        read_spectrum(write(sensors("freq,psd_x [g^2/Hz],psd_y [(m/s^2)^2/Hz]")))


def test_a_sensor_that_shows_nothing_is_refused(write):
    rows = [f"{f},{d},0" for f, d in zip(FREQUENCY, DENSITY, strict=True)]
    with pytest.raises(ValueError, match=r"column 'adxl345 bed': got the highest density 0"):
        read_spectrum(write(text("freq,adxl345 hotend,adxl345 bed", rows)))


def test_frequencies_are_converted_and_that_is_told(write):
    read = read_spectrum(write(text("freq [kHz],psd_x,psd_y,psd_z,psd_xyz")))
    assert read.spectrum.frequency[0] == 2000.0
    assert "in kHz and was converted to Hz" in read.notes[0]


def test_an_unknown_unit_is_refused_with_its_place(write):
    with pytest.raises(ValueError, match=r"csv, row 1: the unit of column 'freq \[s\]"):
        read_spectrum(write(text("freq [s],psd_x,psd_y,psd_z,psd_xyz")))


def test_levels_are_read_as_powers(write):
    levels = 10 * np.log10(np.maximum(DENSITY, 1e-9))
    rows = [f"{f},{level}" for f, level in zip(FREQUENCY, levels, strict=True)]
    read = read_spectrum(write(text("freq,psd_x [dB]", rows)))
    expected = DENSITY[1:] / FREQUENCY[1:]
    assert np.allclose(read.spectrum.power, expected / expected.max(), rtol=1e-12)


@pytest.mark.parametrize("column", ["shapers:", "zv(48.0)", "3hump_ei (60.2 Hz)", "smooth_ei"])
def test_any_column_of_a_shaper_means_normalised_densities(write, column):
    rows = [f"{f},{d},1.0" for f, d in zip(FREQUENCY, DENSITY, strict=True)]
    read = read_spectrum(write(text(f"freq,psd_xyz,{column}", rows)))
    assert read.was_normalised
    assert f"as they are, since column {column!r}" in read.notes[1]


def test_how_densities_are_taken_is_told(write):
    content = text()
    assert "over the frequency, since no column" in read_spectrum(write(content)).notes[1]
    asked = read_spectrum(write(content), normalised=True)
    assert "as they are, as was asked for" in asked.notes[1]


def test_levels_that_no_header_calls_so_are_told_by_what_they_look_like(write):
    rows = "\n".join(f"{f},{30 + 10 / (1 + (f - 12) ** 2):.3f}" for f in range(1, 20))
    note = read_spectrum(write(f"freq,psd_xyz\n{rows}\n")).notes[-1]
    assert "psd_xyz is highest at the first bin, 1 Hz" in note
    assert "[dB]" in note
    with pytest.raises(ValueError, match=r"Levels in decibels have \[dB\] in their header"):
        read_spectrum(write(f"freq,psd_xyz\n{rows.replace(',', ',-')}\n"))


def test_a_spectrum_that_still_rises_is_told(write):
    rising = text().splitlines()[: 1 + 10]  # up to 18 Hz, the peak is at 20
    (note,) = read_spectrum(write("\n".join(rising))).notes[2:]
    assert "psd_xyz still rises at the last bin, 18 Hz, to 100 % of its peak" in note
    assert len(read_spectrum(write(text())).notes) == 2


def test_comments_and_trailing_commas_are_read_over(write):
    plain = read_spectrum(write(text())).spectrum
    lines = text().splitlines()
    commented = "\n".join(["# accel_per_hz: 75", "", *(f"{line}," for line in lines)])
    marked = "\n".join(["# a shake", "#" + lines[0], *lines[1:]])
    for content in (commented, marked):
        assert np.array_equal(read_spectrum(write(content)).spectrum.power, plain.power)


GERMAN = text().replace(",", ";").replace(".", ",")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (GERMAN, r"row 1: the separator is ';' and the decimal point ',', got .* Export .*`tr"),
        (text().replace(",", ";"), r"the separator is ';', got .*`tr ';' ','"),
        (text().replace(",", "\t"), r"the separator is a tab, got"),
        (
            "freq,psd_xyz\n" + "1,5,1503,32\n" * 9,
            r"row 2: the decimal point is ',', got '1,5,1503,32' below 'freq,psd_xyz'",
        ),
        ('freq,psd_xyz\n"1,5","3,2"\n', r"row 2: the decimal point is ','"),
        ("# only a remark\n", r"0 columns of frequency"),
        ("freq,psd_xyz\n1," + "1" * 140_000, r"row 2: field larger than field limit"),
    ],
)
def test_another_separator_is_named(write, content, message):
    with pytest.raises(ValueError, match=message):
        read_spectrum(write(content))


def test_rows_are_counted_as_an_editor_does(write):
    lines = text().splitlines()
    content = "\n".join(["# a remark", "", *lines[:3], "", "5,x,1,1,1"])
    with pytest.raises(ValueError, match=r"row 7, column 'psd_x': got 'x'"):
        read_spectrum(write(content), column="psd_x")
