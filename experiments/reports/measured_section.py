"""What was measured otherwise, beside what the fit makes of it."""

from collections.abc import Iterator
from typing import NamedTuple

from experiments.page.number_text import plain, readable_unit, rounded
from experiments.page.table import Table
from identification.fit.unknowns.measured import Measured, deviation
from identification.result.estimate import Estimate

APART = 3.0
"""Standard errors from which the logs contradict what was measured otherwise [1]."""


class Fitted(NamedTuple):
    """A number that was measured otherwise, and the fit's own."""

    measured: Measured
    """What was measured."""
    value: float
    """The fitted robot's [SI]."""
    deviation: float
    """Fitted minus measured, in the measurement's standard errors [1]."""


def fitted(estimate: Estimate) -> Iterator[Fitted]:
    """What the fit makes of each number that was measured otherwise.

    Args:
        estimate: The estimate.

    Yields:
        The numbers, in the order in which they were given.
    """
    for one in estimate.measured:
        robot = estimate.of_setting(one.setting) if one.setting else estimate.robot
        yield Fitted(one, float(one.of(robot)), deviation(one, robot))


def measured_tables(estimate: Estimate) -> tuple[Table, ...]:
    """What was measured otherwise, beside the fit.

    Args:
        estimate: The estimate.

    Returns:
        One table, or none where nothing was.
    """
    rows = tuple(
        (
            one.name.replace("_", " "),
            one.setting or "",
            rounded(float(one.value), float(one.sigma)),
            rounded(float(one.sigma), float(one.sigma)),
            rounded(value, float(one.sigma)),
            "" if one.unit == "1" else readable_unit(one.unit),
            plain(apart, 2),
        )
        for one, value, apart in fitted(estimate)
    )
    header = ("what", "at", "measured", "± σ", "fitted", "unit", "apart [σ]")
    title = "Measured otherwise, and what the fit makes of it"
    return (Table(title, header, rows),) if rows else ()


def contradictions(estimate: Estimate) -> tuple[str, ...]:
    """Where the logs contradict what was measured otherwise, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence on each such number.
    """
    return tuple(
        f"The logs contradict the {one.name.replace('_', ' ')} that was measured otherwise"
        f"{' at ' + one.setting if one.setting else ''}: it is {plain(abs(apart), 2)} of its "
        "standard errors off. The fit is a compromise between both: find out which is wrong."
        for one, _, apart in fitted(estimate)
        if abs(apart) >= APART
    )
