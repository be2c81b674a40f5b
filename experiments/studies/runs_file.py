"""`runs.csv`: where the fitted robot goes in each run, as a film or a plot needs it."""

import csv
import io
import math
import pathlib
from collections.abc import Iterable

import numpy as np
from jaxtyping import Float

from identification.fit.comparison import Comparison

COLUMNS = ("run", "t [s]", "x_e [m]", "delta_e [rad]", "q_3 [m]", "q_4 [m]", "y_e [m]")
"""The header: the run's name, the time, and the model's coordinates."""
RATE = 25.0
"""Rows a second [Hz]: six a period of the slowest vibration."""


def runs_table(comparisons: Iterable[Comparison]) -> str:
    """The simulated paths of runs as the text of `runs.csv`.

    Args:
        comparisons: The runs; one without cables has no path, and is left out.

    Returns:
        CSV, units in the header.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for run in comparisons:
        if not run.path.size:
            continue
        first, last = float(run.time[0]), float(run.time[-1])
        time = np.linspace(first, last, max(math.ceil(RATE * (last - first)) + 1, 2))
        path = [np.interp(time, run.time, column) for column in run.path.T]
        for at, *row in zip(time.tolist(), *path, strict=True):
            writer.writerow([run.name, f"{at:.4f}", *(f"{number:.7g}" for number in row)])
    return text.getvalue()


def read_runs(
    path: pathlib.Path,
) -> dict[str, tuple[Float[np.ndarray, " rows"], Float[np.ndarray, "rows 5"]]]:
    """Read runs from `runs.csv`.

    Args:
        path: The file.

    Returns:
        Times [s] and positions [m, rad, m, m, m] by the runs' names, in the file's order.

    Raises:
        ValueError: If the file isn't what `scdpr calibrate` writes; says where.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    header = tuple(next(csv.reader(lines[:1]), ()))
    if header != COLUMNS:
        raise ValueError(
            f"{path}, row 1: the header is wrong, got {','.join(header)[:80]!r}, expected "
            f"{','.join(COLUMNS)!r}. Write it anew with `scdpr calibrate`."
        )
    rows: dict[str, list[list[float]]] = {}
    for number, cells in enumerate(csv.reader(lines[1:]), 2):
        rows.setdefault(cells[0] if cells else "", []).append(_row(path, number, cells))
    tables = {name: np.array(table) for name, table in rows.items() if len(table) > 1}
    return {name: (table[:, 0], table[:, 1:]) for name, table in tables.items()}


def _row(path: pathlib.Path, number: int, cells: list[str]) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells[1:]]
    except ValueError:
        numbers = []
    if len(numbers) != len(COLUMNS) - 1 or not np.all(np.isfinite(numbers)):
        raise ValueError(
            f"{path}, row {number}: got {','.join(cells)[:60]!r}, expected a name and "
            f"{len(COLUMNS) - 1} finite numbers. Write it anew with `scdpr calibrate`."
        )
    return numbers
