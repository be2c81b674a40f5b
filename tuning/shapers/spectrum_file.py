"""Reading a measured spectrum from a CSV file, with one clear error."""

import csv
import dataclasses
import math
import pathlib
import re

import numpy as np
from jaxtyping import Float

from tuning.shapers.spectrum import Spectrum

_FREQUENCY = ("freq", "frequency", "f")
_TOTAL = "psd_xyz"
_DENSITY = re.compile(r"psd(_\w+)?|power|p", re.IGNORECASE)
_SHAPER = re.compile(r"\w+\s*\(\s*[\d.]+\s*\)")
"""A further column such as `mzv(48.4)`: whoever wrote it had normalised the densities."""
_FEWEST = 8  # bins: fewer don't show a peak and its sides
_REPORTED = 5  # faults listed in one error
_EXPECTED = "a header such as 'freq,psd_x,psd_y,psd_z,psd_xyz' and a row of numbers per bin"


@dataclasses.dataclass(frozen=True, eq=False)
class SpectrumFile:
    """A spectrum as it was read."""

    path: pathlib.Path
    """The file."""
    spectrum: Spectrum
    """The spectrum."""
    column: str
    """The column, or columns, that it was taken from."""
    was_normalised: bool
    """Whether the file's densities were over the frequency already."""


def read_spectrum(
    path: pathlib.Path,
    *,
    column: str | None = None,
    normalised: bool | None = None,
    lowest: float = 0.0,
) -> SpectrumFile:
    """Read a measured spectrum.

    The file is CSV with a header: one column `freq` or `frequency` [Hz] and densities such
    as `psd_x`, `psd_y`, `psd_z` and their sum `psd_xyz`. Shaking with a force that grows
    with the frequency makes densities grow with it; the spectrum is the density over the
    frequency.

    Args:
        path: The file.
        column: Column of the densities; default: `psd_xyz`, else the sum of those there are.
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
    header, rows = _cells(path)
    names = [_name(label) for label in header]
    frequency_at = _place_of_frequency(path, names)
    places = _places_of_density(path, names, column)
    numbers = _numbers(path, header, rows, [frequency_at, *places])
    frequency, density = numbers[:, 0], numbers[:, 1:].sum(axis=1)
    _check(path, frequency, density, names[frequency_at])
    if normalised is None:
        normalised = any(_SHAPER.fullmatch(label.strip()) for label in header)
    kept = (frequency > 0) & (frequency >= lowest)
    frequency, density = frequency[kept], density[kept]
    if np.count_nonzero(density) < _FEWEST:
        raise ValueError(
            f"{path}: {np.count_nonzero(density)} bins above {lowest:g} Hz with vibration, "
            f"expected at least {_FEWEST}. Record a longer shake, or lower `--lowest`."
        )
    power = density if normalised else density / frequency
    chosen = " + ".join(names[place] for place in places)
    return SpectrumFile(path, Spectrum(frequency, power / power.max()), chosen, normalised)


def _cells(path: pathlib.Path) -> tuple[list[str], list[list[str]]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} isn't UTF-8, got another kind of file, expected "
            f"{_EXPECTED}. Export the spectrum as CSV (UTF-8)."
        ) from error
    rows = [row for row in csv.reader(text.splitlines()) if any(cell.strip() for cell in row)]
    if not rows:
        raise ValueError(
            f"{path}: got an empty file, expected {_EXPECTED}. Export the spectrum again."
        )
    return rows[0], rows[1:]


def _name(label: str) -> str:
    """A column's name: without its unit, and without the mark of a comment before it."""
    return label.strip().lstrip("#").partition("[")[0].strip()


def _place_of_frequency(path: pathlib.Path, names: list[str]) -> int:
    places = [n for n, name in enumerate(names) if name.lower() in _FREQUENCY]
    if len(places) != 1:
        raise ValueError(
            f"{path}, row 1: {len(places)} columns of frequency, got {','.join(names)[:80]!r}, "
            "expected one named 'freq' or 'frequency' [Hz]. Rename it in the header; raw "
            "accelerations have to be made a spectrum first."
        )
    return places[0]


def _places_of_density(path: pathlib.Path, names: list[str], column: str | None) -> list[int]:
    densities = [n for n, name in enumerate(names) if _DENSITY.fullmatch(name)]
    chosen = column or (_TOTAL if _TOTAL in names else None)
    if chosen is not None:
        densities = [n for n, name in enumerate(names) if name == chosen]
    if not densities:
        raise ValueError(
            f"{path}, row 1: no column {chosen or 'psd…'!r}, got {','.join(names)[:80]!r}, "
            "expected a power spectral density such as 'psd_xyz'. Name the column with "
            "`--column`."
        )
    return densities


def _numbers(
    path: pathlib.Path, header: list[str], rows: list[list[str]], places: list[int]
) -> Float[np.ndarray, "bins columns"]:
    faults, numbers = [], []
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            faults.append(f"row {line}: {len(row)} cells, expected {len(header)}")
            continue
        values = [_number(row[place]) for place in places]
        faults += [
            f"row {line}, column {header[place]!r}: got {row[place]!r}"
            for place, value in zip(places, values, strict=True)
            if not (math.isfinite(value) and value >= 0)
        ]
        numbers.append(values)
    if faults:
        rest = len(faults) - _REPORTED
        listed = faults[:_REPORTED] + ([f"and {rest} more"] if rest > 0 else [])
        raise ValueError(
            f"{path}: {'; '.join(listed)}, expected finite numbers, not negative, in every "
            "row. The decimal point is '.'; mend these rows or export the spectrum again."
        )
    return np.array(numbers).reshape(-1, len(places))


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _check(
    path: pathlib.Path,
    frequency: Float[np.ndarray, " bins"],
    density: Float[np.ndarray, " bins"],
    name: str,
) -> None:
    back = np.flatnonzero(np.diff(frequency) <= 0)
    if back.size:
        row = int(back[0]) + 3
        raise ValueError(
            f"{path}, row {row}, column {name!r}: got {frequency[back[0] + 1]:g} after "
            f"{frequency[back[0]]:g}, expected frequencies that increase [Hz]. Sort the rows, "
            "and give each frequency once."
        )
    if frequency.size < _FEWEST or not density.max(initial=0) > 0:
        raise ValueError(
            f"{path}: got {frequency.size} bins of highest density "
            f"{density.max(initial=0):g}, expected at least {_FEWEST} and vibration in them. "
            "Record the spectrum again."
        )
