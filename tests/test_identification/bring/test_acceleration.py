import pathlib

import numpy as np
import pytest

from identification.bring.acceleration import read_acceleration

SHARED = pathlib.Path(__file__).parents[4] / "shared" / "data"
TIME = np.arange(200) * 5e-3
WAVE = np.round(np.sin(9 * TIME), 6)


def text(header, separator=",", comma=False, start=0.0):
    rows = [
        f"{t + start:.6f}{separator}{a:.6f}{separator}{-a:.6f}"
        for t, a in zip(TIME, WAVE, strict=True)
    ]
    body = "\n".join(rows)
    return f"{header}\n{body.replace('.', ',') if comma else body}\n"


@pytest.mark.parametrize(
    ("content", "factor"),
    [
        (text("#time,accel_x,accel_y", start=8000.0), 1.0),
        (text("t [s],a_x [g],a_y [g]"), 9.80665),
        (
            text(
                '"Time (s)";"Acceleration x (m/s^2)";"Acceleration y (m/s^2)"', ";", comma=True
            ),
            1.0,
        ),
        (text("Zeit [s]\tBeschleunigung x [mm/s²]\tBeschleunigung y [mm/s²]", "\t"), 1e-3),
    ],
)
def test_recordings_of_chips_and_phones_are_known_by_their_columns(content, factor, tmp_path):
    (tmp_path / "raw.csv").write_text(content, encoding="utf-8")
    found = read_acceleration(tmp_path / "raw.csv")
    assert len(found.axes) == 2
    np.testing.assert_allclose(next(iter(found.axes.values())), factor * WAVE, rtol=1e-12)
    np.testing.assert_allclose(found.time - found.time[0], TIME, atol=1e-9)


@pytest.mark.skipif(not SHARED.exists(), reason="the shared spectra aren't there")
def test_spectra_are_no_recordings():
    spectra = [*SHARED.glob("klipper/*.csv"), *SHARED.glob("cases/spectrum-*/*.csv")]
    assert spectra
    assert all(read_acceleration(path) is None for path in spectra)
