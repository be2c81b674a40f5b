"""How even the pace of a leg's plain profile is, and the shortest time of the drives."""

import dataclasses

import numpy as np

from scdpr_jax.robot.parameters import Robot
from tuning.plan.led.following import Leader
from tuning.plan.leg import Leg
from tuning.plan.profile import Moment, plain_moments
from tuning.plan.search.scenarios import FITTED, scenarios, starts

ORDERS = (2.0, 4.0, 6.0, 8.0, 10.0)
"""Orders of the plain profile's `pace` to choose from, the paper's first [1]."""
PLAIN_SHARE = 0.92
"""Share of the voltage limit that the plain profile may ask for [1]: the PD answers a count of
the encoders with some 0.6 V, and a saturated drive doesn't follow."""
SHORTEST, LONGEST = 0.5, 60.0
"""Times of legs that are planned [s]: less than a period of the slowest mode is none."""
STRETCH = 1.05
"""By what a time is multiplied that is too short for the drives [1]."""
INSTANTS = 40
"""At how many instants of a leg its plain profile's commands are looked at."""


def paced(robot: Robot, leg: Leg) -> Leg:
    """A leg with the first plain profile of `ORDERS` that the drives can follow in its time.

    Args:
        robot: The robot.
        leg: The leg.

    Returns:
        The leg with the order of its profile; where none can be followed, with the one that
        asks the least of the drives.
    """
    most = PLAIN_SHARE * float(robot.drive.voltage_limit)
    legs = [dataclasses.replace(leg, order=order) for order in ORDERS]
    volts = [plain_voltage(robot, own) for own in legs]
    first = next((k for k, v in enumerate(volts) if v <= most), int(np.argmin(volts)))
    return legs[first]


def plain_voltage(robot: Robot, leg: Leg) -> float:
    """The largest command of a leg's plain profile, the robot lying as it does at the begin.

    Args:
        robot: The robot.
        leg: The leg.

    Returns:
        Largest command of either drive [V].
    """
    time = leg.moving / INSTANTS * np.arange(INSTANTS)
    value, slope, curvature = plain_moments(leg.course, time)
    alone = scenarios(robot, FITTED)
    still = np.broadcast_to(leg.course.begin, value.shape)
    motion = Moment(still[None], slope[None], curvature[None])
    rest = np.repeat(starts(alone, leg).position[:, None], INSTANTS, axis=1)
    return float(np.max(np.abs(Leader(alone.robot).commands(rest, motion))))


def possible(robot: Robot, leg: Leg) -> Leg:
    """A leg in a time in which the drives can follow some plain profile.

    Args:
        robot: The robot.
        leg: The leg in the time that is asked for.

    Returns:
        The leg in that time, or in as many steps of `STRETCH` more as the drives need.
    """
    most = PLAIN_SHARE * float(robot.drive.voltage_limit)
    leg = dataclasses.replace(leg, time=max(leg.time, SHORTEST))
    while plain_voltage(robot, paced(robot, leg)) > most and leg.time < LONGEST:
        leg = dataclasses.replace(leg, time=leg.time * STRETCH)
    return leg
