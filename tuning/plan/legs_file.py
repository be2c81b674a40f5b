"""Tables of legs: those that are asked for, and what is expected of their plans."""

import csv
import io
import math
import pathlib
from collections.abc import Sequence

from scdpr_jax.numerics.files.given import read_given_rows
from scdpr_jax.robot.parameters import Robot
from tuning.plan.planning import Planned, Wanted

COLUMNS = ("x_from [m]", "y_from [m]", "x_to [m]", "y_to [m]", "leg_time [s]")
"""The header of a table of legs."""
SLOPE = "slope [1]"
"""A column that may follow: slope of the carriages' line at the begin, empty where unknown."""
MOST = 100_000
"""Legs of a table, at the most."""


def read_legs(path: pathlib.Path, robot: Robot) -> list[Wanted]:
    """Legs that are asked for.

    Args:
        path: A table with `COLUMNS` and perhaps `SLOPE`.
        robot: The robot whose frame bounds them.

    Returns:
        The legs.

    Raises:
        ValueError: If it isn't such a table; says where.
    """
    try:
        rows = read_given_rows(path)
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected a table of legs with the "
            f"columns {', '.join(COLUMNS)}. Check its name."
        ) from None
    header = tuple(cell.strip() for cell in rows[0][1]) if rows else ()
    if header not in (COLUMNS, (*COLUMNS, SLOPE)):
        raise ValueError(
            f"{path}, row 1: the header is wrong, got {','.join(header)[:80]!r}, expected "
            f"{','.join(COLUMNS)!r}, and perhaps {SLOPE!r} behind it."
        )
    if not 1 < len(rows) <= MOST + 1:
        raise ValueError(
            f"{path}: got {len(rows) - 1} legs, expected 1 to {MOST}. Divide longer tables."
        )
    return [_leg(path, number, row, robot, len(header)) for number, row in rows[1:]]


def _leg(path: pathlib.Path, number: int, row: list[str], robot: Robot, count: int) -> Wanted:
    slope = row[5].strip() if len(row) > len(COLUMNS) else ""
    try:
        numbers = [float(cell) for cell in row[:5]]
        told = float(slope) if slope else None
    except ValueError:
        numbers, told = [], None
    finite = all(map(math.isfinite, (*numbers, told or 0.0)))
    if len(row) != count or len(numbers) != len(COLUMNS) or not finite:
        raise ValueError(
            f"{path}, row {number}: got {','.join(row)[:80]!r}, expected {count} finite "
            "numbers. A slope may be empty."
        )
    x, y, x_to, y_to, time = numbers
    width = float(robot.frame.width)
    low, high = map(float, robot.heights)
    inside = all(0 <= a <= width and low < b < high for a, b in ((x, y), (x_to, y_to)))
    if not inside or time <= 0 or (x, y) == (x_to, y_to):
        raise ValueError(
            f"{path}, row {number}: no leg within the frame, got {','.join(row)[:80]!r}, "
            f"expected two places with x from 0 to {width:g} m and y between {low:g} and "
            f"{high:g} m, and a positive time."
        )
    return Wanted((x, y), (x_to, y_to), time, told)


def expectation(planned: Planned) -> tuple[str, ...]:
    """What is expected of a plan, as the cells of its row.

    Args:
        planned: The plan.

    Returns:
        The cells, without the name of its file.
    """
    numbers = [
        number
        for each in (planned.expected, planned.plain)
        for number in (each.vibration[0], each.worst, abs(each.resting[0]))
    ]
    times = (f"{planned.asked_time:.6f}", f"{planned.leg.time:.6f}")
    return (*times, str(int(planned.is_plain)), *(f"{number:.3e}" for number in numbers))


def expectations_table(names: Sequence[str], expectations: Sequence[Sequence[str]]) -> str:
    """What is expected of plans.

    Args:
        names: Their files.
        expectations: The cells of each, see `expectation`.

    Returns:
        CSV, units in the header.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        (
            "plan",
            "time_asked [s]",
            "time [s]",
            "is_plain [1]",
            "vibration [m]",
            "worst_vibration [m]",
            "resting_error [m]",
            "plain_vibration [m]",
            "plain_worst_vibration [m]",
            "plain_resting_error [m]",
        )
    )
    rows = zip(names, expectations, strict=True)
    writer.writerows((name, *cells) for name, cells in rows)
    return text.getvalue()
