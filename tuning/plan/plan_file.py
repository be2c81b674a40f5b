"""`plan.csv`: what the controller is to follow, sample by sample."""

import csv
import io
import pathlib

import numpy as np

from scdpr_jax.numerics.files import regular, write_whole
from tuning.plan.plan import Plan

COLUMNS = (
    "t [s]",
    "x_ref [m]",
    "y_ref [m]",
    "alpha_ref_1 [rad]",
    "alpha_ref_2 [rad]",
    "feedforward_1 [V]",
    "feedforward_2 [V]",
)
"""The header."""

CAUTION_COLUMN = "model_does_not_fit [1]"
"""Last column, of ones, of a plan for a robot whose fit has failed."""


def plan_table(plan: Plan, *, marked: bool = False) -> str:
    """A plan as the text of `plan.csv`.

    Args:
        plan: The plan.
        marked: Whether it is for a robot whose fit has failed.

    Returns:
        CSV, units in the header.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    mark = ("1",) if marked else ()
    writer.writerow((*COLUMNS, CAUTION_COLUMN) if marked else COLUMNS)
    rows = np.column_stack([plan.position, plan.angle, plan.feedforward])
    for time, row in zip(plan.time, rows, strict=True):
        writer.writerow([f"{time:.6f}", *(f"{number:.9f}" for number in row), *mark])
    return text.getvalue()


def write_plan(path: pathlib.Path, plan: Plan, *, marked: bool = False) -> None:
    """Write a plan as `plan.csv`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        plan: The plan.
        marked: Whether it is for a robot whose fit has failed.
    """
    write_whole(path, plan_table(plan, marked=marked))


def read_plan(path: pathlib.Path) -> Plan:
    """Read a plan from `plan.csv`.

    Args:
        path: The file.

    Returns:
        The plan.

    Raises:
        ValueError: If the file isn't what `scdpr plan` writes; says where.
    """
    path = pathlib.Path(path)
    try:
        lines = regular(path).read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected a plan.csv. Run "
            "`scdpr plan` first."
        ) from None
    header = tuple(next(csv.reader(lines[:1]), ()))
    if header not in (COLUMNS, (*COLUMNS, CAUTION_COLUMN)):
        raise ValueError(
            f"{path}, row 1: the header is wrong, got {','.join(header)!r}, expected "
            f"{','.join(COLUMNS)!r}. Write it anew with `scdpr plan`."
        )
    rows = [
        _row(path, number, line, len(header))
        for number, line in enumerate(csv.reader(lines[1:]), 2)
    ]
    if len(rows) < 2:
        raise ValueError(
            f"{path}: got {len(rows)} rows, expected two at least. Write it anew with "
            "`scdpr plan`."
        )
    table = np.array(rows)
    return Plan(table[:, 0], table[:, 1:3], table[:, 3:5], table[:, 5:7])


def _row(path: pathlib.Path, number: int, cells: list[str], count: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.all(np.isfinite(numbers)):
        raise ValueError(
            f"{path}, row {number}: got {','.join(cells)[:60]!r}, expected "
            f"{count} finite numbers. Write it anew with `scdpr plan`."
        )
    return numbers
