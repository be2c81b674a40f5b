"""Robots as they might be, and starts, that a plan is made for."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Undriven
from scdpr_jax.legs.ensemble import Variation, varied
from scdpr_jax.legs.starts import held_slope
from scdpr_jax.robot.parameters import Robot
from tuning.plan.led.arrival import Goal
from tuning.plan.leg import Leg

FITTED = (Variation(),)
"""The fitted robot alone."""
FARTHEST = (
    *(Variation(tension=share, weight=0.3) for share in (0.97, 1.03)),
    *(Variation(friction=share, weight=0.3) for share in (0.8, 1.2)),
    *(Variation(out_of_line=share, weight=0.2) for share in (0.3, -0.3)),
)
"""Tensions, friction forces and starts out of line at the ends of what is planned for."""
VARIATIONS = (
    *FARTHEST,
    *(Variation(tension=share, weight=0.2) for share in (0.985, 1.015)),
    *(Variation(friction=share, weight=0.2) for share in (0.9, 1.1)),
    *(Variation(out_of_line=share, weight=0.2) for share in (0.6, -0.6)),
)
"""What is planned for: those, what lies between, and steeper starts. Stick and slip are too far
from linear for tangents to stand for them, and corners leave what is between them to chance."""
TOLD = 1 / 3
"""Share of the slopes of `VARIATIONS` that is left possible where the start is told [1]: a
camera's ten frames know it to a tenth of a milliradian."""
OFF_NOMINAL = 0.1
"""Weight of other robots' resting errors over that of the fitted one's [1]: friction that isn't
known decides where they rest, and no motion does."""


class Scenarios(NamedTuple):
    """Robots on a leg with where they begin, stacked."""

    robot: Robot
    """The robots."""
    slope: Float[np.ndarray, " scenarios"]
    """By how much the slopes of their carriages' lines differ from the leg's [1]."""
    weight: Float[np.ndarray, " scenarios"]
    """How much each counts [1]."""
    resting: Float[np.ndarray, " scenarios"]
    """How much its resting error counts [1]."""


def scenarios(
    robot: Robot, variations: tuple[Variation, ...] = VARIATIONS, *, told: bool = False
) -> Scenarios:
    """The robots that a leg is planned for.

    Args:
        robot: The fitted robot, with exact friction.
        variations: How each differs from it, and how it lies.
        told: Whether the leg's start is known to be as it is.

    Returns:
        The robots.
    """
    ensemble = varied(robot, variations, (0.0, 0.0))
    weight = ensemble.weight
    nominal = [dataclasses.replace(own, weight=1.0) == Variation() for own in variations]
    return Scenarios(
        ensemble.robot,
        float(held_slope(robot)) * ensemble.out_of_line * (TOLD if told else 1.0),
        weight,
        np.where(nominal, weight, OFF_NOMINAL * weight),
    )


def shifts(scenarios: Scenarios, leg: Leg) -> Float[np.ndarray, " scenarios"]:
    """How far each robot's lower carriage is from where the leg has it.

    The encoders show no start out of line: the motion is relative to where it begins.

    Args:
        scenarios: The robots.
        leg: The leg.

    Returns:
        Displacements [m].
    """
    return scenarios.slope * leg.start[1]


def starts(scenarios: Scenarios, leg: Leg) -> Undriven:
    """Each robot at rest on its line.

    Args:
        scenarios: The robots.
        leg: The leg, at whose begin every end-effector is in the same place.

    Returns:
        The undriven coordinates, for every motion a row for each robot.
    """
    (x, y), slope = leg.start, leg.slope + scenarios.slope
    upper = x - slope * (np.asarray(scenarios.robot.frame.height) - y)
    position = np.stack([np.full(slope.size, x), np.arctan(slope), upper], axis=1)[None]
    return Undriven(position, np.zeros_like(position))


def goals(scenarios: Scenarios, leg: Leg) -> Goal:
    """Where each robot is to be as the leg ends.

    Args:
        scenarios: The robots.
        leg: The leg.

    Returns:
        Their goals, for every motion.
    """
    place, height = (np.full((1, 1), own) for own in leg.end)
    return Goal(place + shifts(scenarios, leg), place, height)
