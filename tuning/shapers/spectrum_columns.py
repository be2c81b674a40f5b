"""The columns of a measured spectrum's file: what each is, and in which unit.

A header's cell is a name with or without a unit: `freq`, `freq [kHz]`, `frequency (rad/s)`,
`psd_x_dB`. A unit that is written is read or refused, as a spectrum in rad/s that is taken
for Hz gives a shaper that is six times too short.
"""

import dataclasses
import math
import re
from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.files.harmless import represented

Numbers = Float[np.ndarray, " bins"]
Conversion = Callable[[Numbers], Numbers]

HERTZ = {
    "hz": 1.0,
    "hertz": 1.0,
    "1/min": 1 / 60,
    "min^-1": 1 / 60,
    "r/min": 1 / 60,
    "rpm": 1 / 60,
    "cpm": 1 / 60,
    "khz": 1e3,
    "rad/s": 1 / (2 * math.pi),
    "rad_s": 1 / (2 * math.pi),
    "rads^-1": 1 / (2 * math.pi),
    "krad/s": 1e3 / (2 * math.pi),
    "deg/s": 1 / 360,
    "°/s": 1 / 360,
    "rev/s": 1.0,
    "cycles/s": 1.0,
}
"""One of each unit of frequency [Hz], in lower case; `mHz` and `MHz` differ by case alone."""
_BY_CASE = {"mHz": 1e-3, "MHz": 1e6}
_FREQUENCY = ("freq", "freqs", "frequency", "frequencies", "f")
_ANGULAR = ("omega", "ω", "w", "angular frequency", "angular_frequency")

_DENSITY = re.compile(
    r"(?P<kind>psd|asd|power|pxx|p(?=$))"
    r"(?:[_ ](?P<axis>xyz|total|sum|x|y|z)(?![a-z0-9]))?(?:[_ ](?P<sensor>.+))?",
    re.IGNORECASE,
)
_CHIP = re.compile(
    r"(?:[a-z]{2,}\d{2,}\w*|lis\d\w+|accel\w*|imu|sensor|beacon|cartographer|toolhead|hotend|bed)"
    r"\d*(?:[ _,:-].*)?",
    re.IGNORECASE,
)
"""An accelerometer by its part number, with the place where it sits: `adxl345 hotend`."""
_SHAPER = re.compile(
    r"shapers?:?|(?!psd|asd|power|pxx|freq)\w+\s*[(@]\s*[\d.]+\s*(?:hz)?\s*\)?"
    r"|(?:smooth_|um[_-])?(?:zv|mzv|zvd+|ei|[23]hump_ei|si)(?:[ _@:(\[].*)?",
    re.IGNORECASE,
)
"""A column such as `mzv(48.4)`: whoever wrote it had normalised the densities."""

_ACCELERATION = r"\(?(?:[cmuµ]?g0?|gn|[cm]?m/s(?:\^2|/s)|[mu]?v|counts?|lsb|1|a\.?u\.?)\)?"
_LINEAR = re.compile(
    rf"{_ACCELERATION}\^2(?:/hz)?|[cm]?m\^2/s\^[34](?:/hz)?|[cm]?m\^2/\(s\^4hz\)"
    r"|1(?:/hz)?|-|a\.?u\.?|arb\.?|rel\.?|relative|w/hz|linear",
)
_ROOT = re.compile(rf"{_ACCELERATION}/(?:sqrt\(?hz\)?|√hz|hz\^\(?(?:0\.5|1/2)\)?|rthz)")
_DECIBEL = re.compile(r"db.*")


@dataclasses.dataclass(frozen=True)
class Label:
    """A header's cell."""

    text: str
    """As it is written."""
    name: str
    """Without its unit, and without the mark of a comment before it."""
    unit: str
    """The unit as it is written, empty where there is none."""

    @property
    def is_shaper(self) -> bool:
        """Whether the column is a shaper's."""
        return _SHAPER.fullmatch(self.text) is not None

    @property
    def is_frequency(self) -> bool:
        """Whether the column is the frequency."""
        return self.name.lower() in (*_FREQUENCY, *_ANGULAR)

    @property
    def sensor(self) -> str | None:
        """Name of the sensor whose density it is; None where it is none."""
        density = _DENSITY.fullmatch(self.name)
        if density is not None:
            return density["sensor"] or ""
        return self.name if _CHIP.fullmatch(self.name) and not self.is_shaper else None

    @property
    def axis(self) -> str:
        """The one axis, x, y or z, whose density it is; empty for all of a sensor's."""
        density = _DENSITY.fullmatch(self.name)
        axis = (density["axis"] or "").lower() if density else ""
        return axis if len(axis) == 1 else ""


def label(cell: str) -> Label:
    """A header's cell, taken apart.

    Args:
        cell: The cell.

    Returns:
        Its name and its unit.
    """
    text = cell.strip().lstrip("#").strip()
    for pattern in (r"(.*?)\s*\[(.*)\]", r"([^(]*?)\s*\((.*)\)"):
        match = re.fullmatch(pattern, text)
        if match is not None and not _SHAPER.fullmatch(text):
            return Label(text, match[1] or match[2], match[2].strip())
    if text.lower() in HERTZ or text in _BY_CASE:
        return Label(text, "f", text)
    for pattern in (r"(.*?)\s*[,/]\s*(.+)", r"(.*?)(?:[ _]in)?[ _](.+)"):
        match = re.fullmatch(pattern, text)
        if match is not None and _is_unit(match[1], match[2].strip("() ")):
            return Label(text, match[1], match[2].strip("() "))
    return Label(text, text, "")


def _is_unit(name: str, tail: str) -> bool:
    """Whether what follows a name, without brackets, is its unit."""
    unit = _plain(tail)
    if Label("", name, "").is_frequency:
        return unit in HERTZ
    return bool(_DECIBEL.fullmatch(unit) or "hz" in unit)


def frequency_unit(column: Label) -> tuple[str, float]:
    """The unit of a column of frequencies.

    Args:
        column: The column.

    Returns:
        The unit as it is told, and one of it [Hz].

    Raises:
        ValueError: If the unit isn't known.
    """
    if not column.unit:
        angular = column.name.lower() in _ANGULAR
        return ("rad/s", HERTZ["rad/s"]) if angular else ("Hz", 1.0)
    unit = _plain(column.unit)
    factor = _BY_CASE.get(column.unit) or HERTZ.get(unit)
    if factor is None:
        raise ValueError(
            f"the unit of column {represented(column.text)} isn't known, got "
            f"{represented(column.unit)}, expected "
            "Hz, kHz, mHz, rad/s, deg/s or rpm. Convert the column to Hz."
        )
    return column.unit, factor


def density_conversion(column: Label) -> tuple[str, Conversion]:
    """How a column becomes a power spectral density of acceleration, to a constant factor.

    Args:
        column: The column.

    Returns:
        The unit as it is told, and the conversion.

    Raises:
        ValueError: If the unit isn't known or isn't one of power.
    """
    unit = _plain(column.unit)
    if re.search(r"(^|[_ ])(log|ln)(10)?([_ ]|$)", column.name, re.IGNORECASE):
        unit = "log"
    if _DECIBEL.fullmatch(unit):
        return column.unit, _from_decibels
    if _ROOT.fullmatch(unit) or (not unit and column.name.lower().startswith("asd")):
        return column.unit, np.square
    if not unit or _LINEAR.fullmatch(unit):
        return column.unit, np.asarray
    raise ValueError(
        f"the unit of column {represented(column.text)} isn't known, got "
        f"{represented(column.unit or unit)}, "
        "expected a power spectral density of acceleration: (mm/s^2)^2/Hz, (m/s^2)^2/Hz, "
        "g^2/Hz, their root in g/sqrt(Hz), or dB. Convert the column; an amplitude has to be "
        "squared."
    )


def _from_decibels(level: Numbers) -> Numbers:
    """Power of a level; what dB are relative to doesn't matter."""
    return 10 ** (level / 10)


def is_level(column: Label) -> bool:
    """Whether a column is a level, which may be below zero.

    Args:
        column: The column.

    Returns:
        Whether it is in dB.
    """
    return _DECIBEL.fullmatch(_plain(column.unit)) is not None


def _plain(unit: str) -> str:
    """A unit in lower case, without signs that may be left out and with ^ for powers."""
    for written, plain in (
        ("**", "^"),
        ("²", "^2"),
        ("³", "^3"),
        ("⁴", "^4"),
        ("⁻¹", "^-1"),
        ("½", "1/2"),
        ("·", ""),
        ("*", ""),
        ("μ", "u"),
        ("µ", "u"),
        (" ", ""),
    ):
        unit = unit.replace(written, plain)
    return re.sub(r"(?<=[a-z)])([234])(?=/|$|\))", r"^\1", unit.lower())
