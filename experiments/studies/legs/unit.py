"""A unit of a list of legs: some of them, planned wherever it is asked for."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from experiments.runtime.parcel import Parcel, packed, unpacked
from experiments.runtime.robot_parcel import robot_arrays, robot_of
from scdpr_jax.command.controller import PD
from scdpr_jax.provenance import Provenance
from scdpr_jax.robot.parameters import Robot
from tuning.plan.legs_file import expectation
from tuning.plan.plan_file import plan_table
from tuning.plan.planning import Wanted, plan_legs

LEGS = 16
"""Legs of a unit, usually: some seconds' work."""


class PlannedLegs(NamedTuple):
    """What came of the legs of a unit, in their order."""

    tables: Sequence[str]
    """Their plans, as `plan.csv` has them."""
    expectations: Sequence[Sequence[str]]
    """Their rows of `legs.csv`, without the names of their files."""
    longer: int
    """How many take longer than asked for."""
    plain: int
    """How many are the plain profile."""


def parcel(
    robot: Robot,
    controller: PD,
    legs: Sequence[Wanted],
    *,
    unit: int,
    marked: bool,
    provenance: Provenance,
) -> Parcel:
    """A list of legs as plain data.

    Args:
        robot: The fitted robot.
        controller: The PD controller that it will run under.
        legs: What is asked for.
        unit: Legs of a unit.
        marked: Whether it is for a robot whose fit has failed.
        provenance: Where the plans come from.

    Returns:
        The parcel.
    """
    gains = (controller.proportional_gain, controller.derivative_gain)
    rows = [
        (*leg.start, *leg.end, *(np.nan if n is None else n for n in (leg.time, leg.slope)))
        for leg in legs
    ]
    return Parcel(
        {
            "marked": marked,
            "unit": unit,
            "period": float(controller.period),
            "provenance": provenance.model_dump(),
        },
        {
            **robot_arrays(robot),
            "gains": np.array([float(gain) for gain in gains]),
            "legs": np.array(rows, float).reshape(len(legs), 6),
        },
    )


def planned_of(content: bytes) -> PlannedLegs:
    """What came of a unit's legs.

    Args:
        content: The unit's result.

    Returns:
        The plans.
    """
    return PlannedLegs(**unpacked(content).facts)


def begin(given: Parcel) -> Callable[[int, bytes], bytes]:
    """What plans the units of a list of legs.

    Args:
        given: The list.

    Returns:
        From a unit's number to its plans, packed.
    """
    robot, table = robot_of(given.arrays), given.arrays["legs"]
    controller = PD(*map(float, given.arrays["gains"]), period=given.facts["period"])
    marked, unit = given.facts["marked"], given.facts["unit"]
    provenance = Provenance(**given.facts["provenance"])

    def computed(number: int, payload: bytes) -> bytes:
        rows = table[number * unit : (number + 1) * unit].tolist()
        made = plan_legs(robot, controller, list(map(_wanted, rows)))
        found = PlannedLegs(
            [plan_table(own.plan, marked=marked, provenance=provenance) for own in made],
            [expectation(own) for own in made],
            sum(own.leg.time > own.asked_time for own in made),
            sum(own.is_plain for own in made),
        )
        return packed(Parcel(found._asdict()))

    return computed


def _wanted(row: Sequence[float]) -> Wanted:
    x, y, x_to, y_to, *rest = row
    time, slope = (None if np.isnan(own) else own for own in rest)
    return Wanted((x, y), (x_to, y_to), time, slope)
