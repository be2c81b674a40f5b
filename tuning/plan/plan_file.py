"""`plan.csv`: what the controller is to follow, sample by sample."""

import csv
import io
import pathlib

import numpy as np

from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.files.given import read_given_rows
from scdpr_jax.numerics.files.harmless import cell, represented
from scdpr_jax.provenance import UNKNOWN, Provenance
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
_MADE = "Made by scdpr-jax"
"""What the header's last cell begins with where it tells where the plan comes from."""


def plan_table(plan: Plan, *, marked: bool = False, provenance: Provenance = UNKNOWN) -> str:
    """A plan as the text of `plan.csv`.

    Where it comes from is a cell of the header alone, with no column below it: whoever reads
    the numbers gets the same ones, and as many in a row.

    Args:
        plan: The plan.
        marked: Whether it is for a robot whose fit has failed.
        provenance: Where it comes from.

    Returns:
        CSV, units in the header.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    mark = ("1",) if marked else ()
    told = () if provenance == UNKNOWN else (cell(str(provenance)),)
    writer.writerow((*COLUMNS, *((CAUTION_COLUMN,) if marked else ()), *told))
    rows = np.column_stack([plan.position, plan.angle, plan.feedforward])
    for time, row in zip(plan.time, rows, strict=True):
        writer.writerow([f"{time:.6f}", *(f"{number:.9f}" for number in row), *mark])
    return text.getvalue()


def write_plan(
    path: pathlib.Path, plan: Plan, *, marked: bool = False, provenance: Provenance = UNKNOWN
) -> None:
    """Write a plan as `plan.csv`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        plan: The plan.
        marked: Whether it is for a robot whose fit has failed.
        provenance: Where it comes from.
    """
    write_whole(path, plan_table(plan, marked=marked, provenance=provenance))


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
        lines = read_given_rows(path)
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected a plan.csv. Run "
            "`scdpr plan` first."
        ) from None
    header = tuple(lines[0][1]) if lines else ()
    if header and header[-1].startswith(_MADE):
        header = header[:-1]
    if header not in (COLUMNS, (*COLUMNS, CAUTION_COLUMN)):
        raise ValueError(
            f"{path}, row 1: the header is wrong, got {represented(','.join(header))}, "
            f"expected {','.join(COLUMNS)!r}. Write it anew with `scdpr plan`."
        )
    rows = [_row(path, number, cells, len(header)) for number, cells in lines[1:]]
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
