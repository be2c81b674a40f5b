"""The log of one motor-driven axis: time, voltage and position, from a CSV file."""

import csv
import itertools
import math
import pathlib
from typing import NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import real, si

_SHORTEST = 16  # samples: four parameters, and as much again for each to be judged by
_REPORTED = 10  # faults listed in one error


class AxisLog(eqx.Module):
    """What was commanded to an axis and where it went, one row for each sample."""

    time: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("s", "t"))
    """Time of each sample [s], strictly increasing."""
    voltage: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("V", "u"))
    """Command, held until the next sample [V]."""
    position: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("m", "q"))
    """Position [m], or angle [rad] of a rotary axis."""
    position_unit: str = eqx.field(default="m", static=True)
    """SI unit of the positions: "m" or "rad"."""


class _Column(NamedTuple):
    """A column that an axis log has, and the factors of its units to SI."""

    name: str
    units: dict[str, tuple[str, float]]


_COLUMNS = (
    _Column("t", {"s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6)}),
    _Column("voltage", {"V": ("V", 1.0), "mV": ("V", 1e-3)}),
    _Column(
        "position",
        {
            "m": ("m", 1.0),
            "cm": ("m", 1e-2),
            "mm": ("m", 1e-3),
            "um": ("m", 1e-6),
            "rad": ("rad", 1.0),
            "deg": ("rad", math.pi / 180),
            "rev": ("rad", 2 * math.pi),
        },
    ),
)


def read_axis_log(path: pathlib.Path) -> AxisLog:
    """Read the log of one axis.

    The file is CSV with a header row; a column's header is its name and its unit in
    square brackets: `t [s],voltage [V],position [m]`. Other columns are ignored.

    Args:
        path: The CSV file.

    Returns:
        The log in SI units.

    Raises:
        FileNotFoundError: If there is no such file.
        ValueError: If a column or unit is missing, a cell isn't a finite number, a row is
            cut, or time doesn't increase. The message lists the faults with their rows.
    """
    path = pathlib.Path(path)
    rows = _rows(path)
    if not rows:
        raise ValueError(
            f"{path}: the file is empty, expected a header row such as "
            "'t [s],voltage [V],position [m]' and a row per sample. Export the log again."
        )
    header = [cell.strip() for cell in rows[0]]
    if len(header) < len(_COLUMNS):
        raise ValueError(
            f"{path}, row 1: got {rows[0]}, expected at least {len(_COLUMNS)} columns "
            "separated by commas, such as 't [s],voltage [V],position [m]'. Export the log "
            "with commas, and '.' as decimal point."
        )
    columns = [_find(path, header, column) for column in _COLUMNS]
    samples = _numbers(path, rows, header, [place for place, _, _ in columns])
    if len(samples) < _SHORTEST:
        raise ValueError(
            f"{path}: {len(samples)} samples, expected at least {_SHORTEST}. "
            "Four parameters need a record in which the axis moves: log a longer run."
        )
    _check_time(path, [row[0] for row in samples], header[columns[0][0]])
    time, voltage, position = np.array(samples).T * [[factor] for _, _, factor in columns]
    return AxisLog(time, voltage, position, columns[2][1])


def _rows(path: pathlib.Path) -> list[list[str]]:
    """The file's rows of cells; a byte-order mark and blank lines at the end are dropped."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} isn't UTF-8, expected a UTF-8 text file. "
            "Export the log as CSV (UTF-8)."
        ) from error
    rows = list(csv.reader(text.splitlines()))
    while rows and not any(cell.strip() for cell in rows[-1]):
        rows.pop()
    return rows


def _find(path: pathlib.Path, header: list[str], column: _Column) -> tuple[int, str, float]:
    """Where a column stands, its SI unit and the factor to it."""
    labels = [label.partition("[") for label in header]
    places = [i for i, (name, _, _) in enumerate(labels) if name.strip() == column.name]
    expected = " or ".join(f"'{column.name} [{unit}]'" for unit in column.units)
    if len(places) != 1:
        what = "no column" if not places else f"{len(places)} columns"
        raise ValueError(
            f"{path}, row 1: {what} '{column.name}' in {','.join(header)!r}, expected one "
            f"column {expected}. Rename it in the header, or export it with the log."
        )
    _, bracket, rest = labels[places[0]]
    unit = rest.rpartition("]")[0].strip()
    if not bracket or unit not in column.units:
        raise ValueError(
            f"{path}, row 1, column {places[0] + 1}: got {header[places[0]]!r}, expected "
            f"{expected}. A unit is never guessed: write it in square brackets."
        )
    return places[0], *column.units[unit]


def _numbers(
    path: pathlib.Path, rows: list[list[str]], header: list[str], places: list[int]
) -> list[list[float]]:
    """The cells of the chosen columns as finite numbers, or one error with every fault."""
    faults, samples = [], []
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            faults.append(
                f"row {line}: {len(row)} cells, expected {len(header)} as in the header"
            )
            continue
        values = [_number(row[place]) for place in places]
        faults += [
            f"row {line}, column {header[place]!r}: got {row[place]!r}, not a finite number"
            for place, value in zip(places, values, strict=True)
            if value is None
        ]
        samples.append([value for value in values if value is not None])
    if faults:
        rest = len(faults) - _REPORTED
        lines = faults[:_REPORTED] + ([f"and {rest} more"] if rest > 0 else [])
        raise ValueError(
            f"{path}: {'; '.join(lines)}. The decimal point is '.', and a sample that is "
            "missing can't be guessed: mend these rows or cut the log before them."
        )
    return samples


def _number(cell: str) -> float | None:
    """A cell's finite number, None if it holds none."""
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _check_time(path: pathlib.Path, times: list[float], label: str) -> None:
    """Refuse a clock that stands still or runs back."""
    for line, (before, after) in enumerate(itertools.pairwise(times), start=3):
        if not after > before:
            raise ValueError(
                f"{path}, row {line}, column {label!r}: got {after} after {before}, expected "
                "time to increase strictly. Remove the repeated row, or export time with "
                "more digits."
            )
