"""Units of a spectrum's columns: what is known is converted, what isn't is refused."""

import math

import numpy as np
import pytest

from tuning.shapers.spectrum_columns import density_conversion, frequency_unit, label


@pytest.mark.parametrize(
    ("cell", "hertz"),
    [
        ("freq", 1.0),
        ("frequency [Hz]", 1.0),
        ("# freq (hertz)", 1.0),
        ("freq [kHz]", 1e3),
        ("frequency_khz", 1e3),
        ("freq [mHz]", 1e-3),
        ("freq [MHz]", 1e6),
        ("f/kHz", 1e3),
        ("kHz", 1e3),
        ("frequency [rad/s]", 1 / (2 * math.pi)),
        ("freq rad/s", 1 / (2 * math.pi)),
        ("omega", 1 / (2 * math.pi)),
        ("omega [Hz]", 1.0),
        ("frequency [rpm]", 1 / 60),
        ("freq [1/min]", 1 / 60),
        ("freq (min⁻¹)", 1 / 60),
        ("freq [deg/s]", 1 / 360),
    ],
)
def test_a_unit_of_frequency_is_converted(cell, hertz):
    column = label(cell)
    assert column.is_frequency
    assert frequency_unit(column)[1] == pytest.approx(hertz, rel=1e-15)


@pytest.mark.parametrize("unit", ["1/s", "s", "bins", "Hz/s", "octave", "-"])
def test_another_unit_of_frequency_is_refused(unit):
    with pytest.raises(ValueError, match=r"isn't known, got .*, expected Hz, kHz.* Convert"):
        frequency_unit(label(f"freq [{unit}]"))


@pytest.mark.parametrize(
    "cell",
    [
        "psd_x",
        "psd_xyz [(mm/s^2)^2/Hz]",
        "psd_xyz [(m/s²)²/Hz]",
        "psd_x ((m/s2)2/Hz)",
        "power [g^2/Hz]",
        "psd [m^2/s^3]",
        "psd [a.u.]",
        "pxx [V**2/Hz]",
    ],
)
def test_a_density_of_power_is_taken_as_it_is(cell):
    column = label(cell)
    assert column.sensor == ""
    assert density_conversion(column)[1](np.array([2.0, 3.0])).tolist() == [2.0, 3.0]


@pytest.mark.parametrize("cell", ["psd_x [dB]", "psd_dB", "power [dB re 1 g²/Hz]", "p (dB)"])
def test_a_level_becomes_the_power_that_it_stands_for(cell):
    power = density_conversion(label(cell))[1](np.array([0.0, 10.0, -3.0]))
    assert power == pytest.approx([1.0, 10.0, 10**-0.3], rel=1e-14)


@pytest.mark.parametrize("cell", ["asd_x", "asd [g/√Hz]", "psd [m/s^2/sqrt(Hz)]"])
def test_the_root_of_a_density_is_squared(cell):
    assert density_conversion(label(cell))[1](np.array([3.0])).tolist() == [9.0]


@pytest.mark.parametrize("cell", ["psd [g]", "psd [m/s^2]", "psd [mm^2/Hz]", "psd_log10"])
def test_what_is_no_density_of_acceleration_is_refused(cell):
    with pytest.raises(ValueError, match=r"isn't known, got .*\(mm/s\^2\)\^2/Hz.* Convert"):
        density_conversion(label(cell))


@pytest.mark.parametrize(
    "cell", ["mzv(48.4)", "zv (48.0)", "3hump_ei(93.4)", "shapers:", "smooth_zv(50.1 Hz)", "ei"]
)
def test_a_shaper_is_neither_a_sensor_nor_a_frequency(cell):
    column = label(cell)
    assert (column.is_shaper, column.sensor, column.is_frequency) == (True, None, False)


@pytest.mark.parametrize(
    ("cell", "sensor", "axis"),
    [
        ("psd_x", "", "x"),
        ("psd_xyz", "", ""),
        ("psd_x hotend", "hotend", "x"),
        ("psd_xyz_bed", "bed", ""),
        ("adxl345 hotend", "adxl345 hotend", ""),
        ("adxl345, hotend", "adxl345, hotend", ""),
        ("lis2dw bed", "lis2dw bed", ""),
        ("mpu9250", "mpu9250", ""),
        ("coherence", None, ""),
    ],
)
def test_a_sensor_is_told_by_its_name(cell, sensor, axis):
    column = label(cell)
    assert (column.sensor, column.axis, column.is_shaper) == (sensor, axis, False)
