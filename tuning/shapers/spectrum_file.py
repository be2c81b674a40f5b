"""Reading a measured spectrum from a CSV file, with one clear error.

The file is CSV with a header: one column of frequencies, such as `freq` [Hz], and densities:
`psd_x`, `psd_y`, `psd_z` and their sum `psd_xyz`, or one column for each of several sensors,
`adxl345 hotend` and `adxl345 bed`. Every column has the unit that its header says, and what
was made of the columns is told, because a file alone doesn't say all of it.
"""

import dataclasses
import itertools
import math
import pathlib
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.files.harmless import represented
from tuning.shapers.spectrum import THRESHOLD, Spectrum
from tuning.shapers.spectrum_columns import (
    Label,
    density_conversion,
    frequency_unit,
    is_level,
    label,
)
from tuning.shapers.spectrum_table import SpectrumTable, read_table

_FEWEST = 8  # bins: fewer don't show a peak and its sides
_REPORTED = 5  # faults listed in one error
_TAIL = 0.05  # share of the bins, the last, that tell whether the spectrum still rises
_HIGHEST_LEVEL = 3000.0  # dB; powers above 10^300 are none of a machine's

Numbers = Float[np.ndarray, " bins"]


@dataclasses.dataclass(frozen=True, eq=False)
class SpectrumFile:
    """A spectrum as it was read."""

    path: pathlib.Path
    """The file."""
    spectrum: Spectrum
    """The spectrum, of one sensor or of several."""
    columns: tuple[str, ...]
    """The column, or the sum of columns, that each sensor's was taken from."""
    was_normalised: bool
    """Whether the file's densities were over the frequency already."""
    notes: tuple[str, ...]
    """How the columns were taken, and what the spectrum can't show, in words."""

    @property
    def column(self) -> str:
        """The columns that it was taken from."""
        return ", ".join(self.columns)


@dataclasses.dataclass(frozen=True)
class _Sensor:
    """A sensor's densities in a file."""

    name: str
    places: tuple[int, ...]


def read_spectrum(
    path: pathlib.Path,
    *,
    column: str | Sequence[str] | None = None,
    normalised: bool | None = None,
    lowest: float = 0.0,
) -> SpectrumFile:
    """Read a measured spectrum.

    Shaking with a force that grows with the frequency makes densities grow with it; the
    spectrum is the density over the frequency. Several sensors are kept apart: a shaper is
    judged by the one at which it leaves most.

    Args:
        path: The file.
        column: Columns of the densities, one a sensor; default: each sensor's total, else the
            sum of its axes.
        normalised: Whether the densities are over the frequency already; default: if the
            header has columns of shapers, such as `mzv(48.4)`, they are.
        lowest: Frequencies up to here are left out [Hz]; 0 is, always.

    Returns:
        The spectrum, and how it was read.

    Raises:
        FileNotFoundError: If there is no such file.
        ValueError: If it isn't such a file. The message says where, what was found, what was
            expected and what to do.
    """
    path = pathlib.Path(path)
    table = read_table(path)
    labels = [label(cell) for cell in table.header]
    at = _place_of_frequency(table, labels)
    sensors = _named(table, labels, column) if column else _sensors(table, labels)
    frequency, densities = _converted(table, labels, at, sensors)
    _check_frequency(table, frequency, labels[at].text)
    shaper = next((each.text for each in labels if each.is_shaper), None)
    was_normalised = shaper is not None if normalised is None else normalised
    kept = (frequency > 0) & (frequency >= lowest)
    frequency, densities = frequency[kept], densities[:, kept]
    _check_vibration(path, sensors, densities, lowest)
    power = densities if was_normalised else densities / frequency
    power = power / power.max(axis=1, keepdims=True)
    spectrum = Spectrum(frequency, power[0] if len(sensors) == 1 else power)
    notes = (
        _frequencies(labels[at]),
        _taken(labels, sensors, shaper, normalised),
        *_unused(labels, sensors, at),
        *_rising(spectrum, sensors),
        *_falling(spectrum, sensors),
    )
    return SpectrumFile(path, spectrum, tuple(s.name for s in sensors), was_normalised, notes)


def _place_of_frequency(table: SpectrumTable, labels: list[Label]) -> int:
    places = [n for n, each in enumerate(labels) if each.is_frequency]
    if len(places) != 1:
        raise ValueError(
            f"{table.path}, row {table.line}: {len(places)} columns of frequency, got "
            f"{_shown(table)!r}, expected one named 'freq' or 'frequency' [Hz]. Rename it in "
            "the header; a raw recording of accelerations needs a column of time."
        )
    return places[0]


def _shown(table: SpectrumTable) -> str:
    return ",".join(table.header)[:80]


def _named(
    table: SpectrumTable, labels: list[Label], column: str | Sequence[str]
) -> list[_Sensor]:
    """The columns that were asked for."""
    sensors = []
    for name in (column,) if isinstance(column, str) else column:
        places = [n for n, each in enumerate(labels) if name in (each.name, each.text)]
        if not places:
            raise ValueError(_no_density(table, name))
        sensors += [_Sensor(labels[place].name, (place,)) for place in places]
    return sensors


def _sensors(table: SpectrumTable, labels: list[Label]) -> list[_Sensor]:
    """Every sensor of a file: its totals, else the sum of its axes."""
    places = [n for n, each in enumerate(labels) if each.sensor is not None]
    if not places:
        raise ValueError(_no_density(table, "psd…"))
    sensors = []
    for name in dict.fromkeys(labels[place].sensor for place in places):
        every = [place for place in places if labels[place].sensor == name]
        totals = [place for place in every if not labels[place].axis]
        if totals:
            sensors += [_Sensor(labels[place].name, (place,)) for place in totals]
            continue
        axes = [labels[place].axis for place in every]
        if len(set(axes)) < len(axes):
            raise ValueError(
                f"{table.path}, row {table.line}: an axis twice, got {_shown(table)!r}, "
                "expected one column an axis. Give each sensor's columns its name, such as "
                "'psd_x hotend'."
            )
        _check_one_unit(table, [labels[place] for place in every])
        sensors.append(_Sensor(" + ".join(labels[p].name for p in every), tuple(every)))
    return sensors


def _no_density(table: SpectrumTable, name: str) -> str:
    return (
        f"{table.path}, row {table.line}: no column {name!r}, got {_shown(table)!r}, expected "
        "a power spectral density such as 'psd_xyz'. Name the column with `--column`."
    )


def _check_one_unit(table: SpectrumTable, summed: list[Label]) -> None:
    if len({each.unit for each in summed}) > 1:
        raise ValueError(
            f"{table.path}, row {table.line}: axes in several units, got "
            f"{','.join(each.text for each in summed)!r}, expected one unit. Convert them, or "
            "name one column with `--column`."
        )


def _converted(
    table: SpectrumTable, labels: list[Label], at: int, sensors: list[_Sensor]
) -> tuple[Numbers, Float[np.ndarray, "sensors bins"]]:
    """Frequencies [Hz] and a density for each sensor, to a constant factor."""
    places = list(dict.fromkeys([at, *(p for sensor in sensors for p in sensor.places)]))
    try:
        _, factor = frequency_unit(labels[at])
        conversions = {place: density_conversion(labels[place])[1] for place in places[1:]}
    except ValueError as error:
        raise ValueError(f"{table.path}, row {table.line}: {error}") from None
    numbers = dict(zip(places, _numbers(table, labels, places).T, strict=True))
    densities = [
        sum(conversions[place](numbers[place]) for place in sensor.places) for sensor in sensors
    ]
    return numbers[at] * factor, np.array(densities)


def _numbers(
    table: SpectrumTable, labels: list[Label], places: list[int]
) -> Float[np.ndarray, "bins columns"]:
    faults, numbers, negative = [], [], False
    for line, row in table.rows:
        if len(row) != len(table.header):
            faults.append(f"row {line}: {len(row)} cells, expected {len(table.header)}")
            continue
        values = [_number(row[place]) for place in places]
        faults += [
            f"row {line}, column {represented(labels[place].text)}: got "
            f"{represented(row[place])}"
            for place, value in zip(places, values, strict=True)
            if not _is_possible(value, labels[place])
        ]
        numbers.append(values)
        negative |= any(-math.inf < value < 0 for value in values[1:])
    if faults:
        rest = len(faults) - _REPORTED
        listed = faults[:_REPORTED] + ([f"and {rest} more"] if rest > 0 else [])
        levels = " Levels in decibels have [dB] in their header." if negative else ""
        raise ValueError(
            f"{table.path}: {'; '.join(listed)}, expected finite numbers, not negative, in "
            "every row. The decimal point is '.'; mend these rows or export the spectrum "
            f"again.{levels}"
        )
    return np.array(numbers, dtype=float).reshape(-1, len(places))


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _is_possible(value: float, column: Label) -> bool:
    if is_level(column):
        return abs(value) <= _HIGHEST_LEVEL
    return math.isfinite(value) and value >= 0


def _check_frequency(table: SpectrumTable, frequency: Numbers, name: str) -> None:
    back = np.flatnonzero(np.diff(frequency) <= 0)
    if back.size:
        line = table.rows[int(back[0]) + 1][0]
        raise ValueError(
            f"{table.path}, row {line}, column {represented(name)}: got "
            f"{frequency[back[0] + 1]:g} after {frequency[back[0]]:g}, expected frequencies "
            "that increase [Hz]. Sort the rows, and give each frequency once."
        )
    if frequency.size < _FEWEST:
        raise ValueError(
            f"{table.path}: got {frequency.size} bins of frequency, expected at least "
            f"{_FEWEST} and vibration in them. Record the spectrum again."
        )


def _check_vibration(
    path: pathlib.Path,
    sensors: list[_Sensor],
    densities: Float[np.ndarray, "sensors bins"],
    lowest: float,
) -> None:
    for sensor, density in zip(sensors, densities, strict=True):
        shaking = np.count_nonzero(density)
        if not shaking:
            raise ValueError(
                f"{path}, column {sensor.name!r}: got the highest density 0, expected "
                "vibration. Record the spectrum again; the sensor may not have been connected."
            )
        if shaking < _FEWEST:
            raise ValueError(
                f"{path}, column {sensor.name!r}: {shaking} bins above {lowest:g} Hz with "
                f"vibration, expected at least {_FEWEST}. Record a longer shake, or lower "
                "`--lowest`."
            )


def _frequencies(column: Label) -> str:
    unit, factor = frequency_unit(column)
    stated = "" if column.unit else ", which its header doesn't say"
    converted = "" if factor == 1 else " and was converted to Hz"
    return f"Column {column.text!r} is the frequency; it is in {unit}{stated}{converted}."


def _taken(
    labels: list[Label], sensors: list[_Sensor], shaper: str | None, asked: bool | None
) -> str:
    """How the densities were taken, and why."""
    if asked is not None:
        how, why = ("as they are" if asked else "over the frequency"), "as was asked for"
    elif shaper is not None:
        how = "as they are"
        why = f"since column {shaper!r} says that they were divided by the frequency"
    else:
        how = "over the frequency"
        why = "since no column of a shaper says that they are already (then `--normalised`)"
    units = [labels[sensor.places[0]].unit for sensor in sensors]
    columns = ", ".join(
        f"{sensor.name} [{unit}]" if unit else sensor.name
        for sensor, unit in zip(sensors, units, strict=True)
    )
    several = (
        f" of {len(sensors)} sensors, the worst of which counts," if len(sensors) > 1 else ""
    )
    return f"Densities{several} from {columns}: taken {how}, {why}."


def _unused(labels: list[Label], sensors: list[_Sensor], at: int) -> list[str]:
    """What no sensor's total explains."""
    used = {at, *itertools.chain.from_iterable(sensor.places for sensor in sensors)}
    rest = [
        each.text
        for place, each in enumerate(labels)
        if place not in used and each.text and not each.is_shaper and not each.axis
    ]
    return [f"Columns that aren't used: {', '.join(rest)}."] if rest else []


def _rising(spectrum: Spectrum, sensors: list[_Sensor]) -> list[str]:
    """Whether a spectrum ends on the way up: then there is a peak that it doesn't show."""
    notes, last = [], spectrum.frequency[-1]
    for sensor, power in zip(sensors, spectrum.by_sensor, strict=True):
        tail = power[-max(4, round(_TAIL * power.size)) :]
        first, second = np.array_split(tail, 2)
        rises = power[-1] >= tail.max() and second.mean() > first.mean()
        if rises and power[-1] > THRESHOLD:
            notes.append(
                f"{sensor.name} still rises at the last bin, {last:.4g} Hz, to "
                f"{100 * power[-1]:.0f} % of its peak: what is above isn't in the file, and "
                "no shaper here is for it. Record up to higher frequencies."
            )
    return notes


def _falling(spectrum: Spectrum, sensors: list[_Sensor]) -> list[str]:
    """Whether a spectrum begins at its highest: then that is hardly a machine's vibration."""
    return [
        f"{sensor.name} is highest at the first bin, {spectrum.frequency[0]:.4g} Hz, where no "
        "peak can be told: an offset of the sensor looks like this, and so do levels in "
        "decibels whose header doesn't say [dB]. `--lowest` leaves low frequencies out."
        for sensor, power in zip(sensors, spectrum.by_sensor, strict=True)
        if power.argmax() == 0
    ]
