"""`plan.csv`: what the controller is to follow, sample by sample."""

import csv
import io
import pathlib

import numpy as np

from scdpr_jax.numerics.files import write_whole
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


def plan_table(plan: Plan) -> str:
    """A plan as the text of `plan.csv`.

    Args:
        plan: The plan.

    Returns:
        CSV, units in the header.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    rows = np.column_stack([plan.position, plan.angle, plan.feedforward])
    for time, row in zip(plan.time, rows, strict=True):
        writer.writerow([f"{time:.6f}", *(f"{number:.9f}" for number in row)])
    return text.getvalue()


def write_plan(path: pathlib.Path, plan: Plan) -> None:
    """Write a plan as `plan.csv`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        plan: The plan.
    """
    write_whole(path, plan_table(plan))


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
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected a plan.csv. Run "
            "`scdpr plan` first."
        ) from None
    header = tuple(next(csv.reader(lines[:1]), ()))
    if header != COLUMNS:
        raise ValueError(
            f"{path}, row 1: the header is wrong, got {','.join(header)!r}, expected "
            f"{','.join(COLUMNS)!r}. Write it anew with `scdpr plan`."
        )
    rows = [_row(path, number, line) for number, line in enumerate(csv.reader(lines[1:]), 2)]
    if len(rows) < 2:
        raise ValueError(
            f"{path}: got {len(rows)} rows, expected two at least. Write it anew with "
            "`scdpr plan`."
        )
    table = np.array(rows)
    return Plan(table[:, 0], table[:, 1:3], table[:, 3:5], table[:, 5:7])


def _row(path: pathlib.Path, number: int, cells: list[str]) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        numbers = []
    if len(numbers) != len(COLUMNS) or not np.all(np.isfinite(numbers)):
        raise ValueError(
            f"{path}, row {number}: got {','.join(cells)[:60]!r}, expected "
            f"{len(COLUMNS)} finite numbers. Write it anew with `scdpr plan`."
        )
    return numbers
