"""Random legs as planned for the fitted robot, driven on robots as they might be."""

import concurrent.futures
import dataclasses

import jax
import numpy as np

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.starts import held_slope
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.parameters import Robot
from tuning.gains.legs import Legs
from tuning.plan.expectation import driven
from tuning.plan.leg import Leg
from tuning.plan.planning import Wanted, plan_legs
from tuning.result.prediction import LegsOutcome


def planned_legs(
    fitted: Robot,
    controller: PD,
    legs: Legs,
    *,
    processes: concurrent.futures.Executor | None = None,
    progress: Progress = SILENT,
) -> LegsOutcome:
    """What legs come to as they are planned.

    The planner knows the fitted robot and where a camera sees each leg begin; the leg is driven
    on a robot of its own.

    Args:
        fitted: The fitted robot, with exact friction.
        controller: The controller that the plans run under.
        legs: The legs with their robots.
        processes: Who plans them, see `plan_legs`.
        progress: Told which share of the plans is made.

    Returns:
        Vibration and resting error of each.
    """
    rows = [jax.tree.map(lambda leaf, k=k: leaf[k : k + 1], legs) for k in range(len(legs))]
    slopes = [_slope(row) for row in rows]
    wanted = [
        Wanted(_pair(row.ensemble.position), _pair(row.end), float(row.time[0]), slope or None)
        for row, slope in zip(rows, slopes, strict=True)
    ]
    outcomes = []
    plans = plan_legs(fitted, controller, wanted, processes=processes, progress=progress)
    for row, slope, planned in zip(rows, slopes, plans, strict=True):
        leg: Leg = dataclasses.replace(planned.leg, slope=0.0)
        robot, plan = row.ensemble.robot, planned.simulated
        outcomes.append(driven(robot, controller, leg, plan, slope=np.array([slope])))
    return LegsOutcome(
        np.array([own.vibration[0] for own in outcomes]),
        np.array([abs(own.resting[0]) for own in outcomes]),
    )


def _slope(row: Legs) -> float:
    """Slope of the line between the carriages at a leg's begin [1]."""
    robot = row.ensemble.robot
    return float(held_slope(robot)[0]) * float(row.ensemble.out_of_line[0])


def _pair(place: np.ndarray) -> tuple[float, float]:
    x, y = map(float, place[0])
    return x, y
