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


class Pace:
    """The plain profiles that the drives of a robot can follow."""

    def __init__(self, robot: Robot):
        """The robot is stacked here, once for all of its legs.

        Args:
            robot: The robot.
        """
        self._alone = scenarios(robot, FITTED)
        self._leader = Leader(self._alone.robot)
        self._most = PLAIN_SHARE * float(robot.drive.voltage_limit)

    def voltage(self, leg: Leg) -> float:
        """The largest command of a leg's plain profile, the robot lying as at its begin.

        Args:
            leg: The leg.

        Returns:
            Largest command of either drive [V].
        """
        time = leg.moving / INSTANTS * np.arange(INSTANTS)
        value, slope, curvature = plain_moments(leg.course, time)
        still = np.broadcast_to(leg.course.begin, value.shape)
        motion = Moment(*(own[None, None] for own in (still, slope, curvature)))
        rest = np.repeat(starts(self._alone, leg).position[:, :, None], INSTANTS, axis=2)
        return float(np.max(np.abs(self._leader.commands(rest, motion))))

    def paced(self, leg: Leg) -> Leg:
        """A leg with the first plain profile of `ORDERS` that can be followed in its time.

        Args:
            leg: The leg.

        Returns:
            The leg with the order of its profile; where none can be followed, with the one
            that asks the least of the drives.
        """
        asked = {}
        for order in ORDERS:
            own = dataclasses.replace(leg, order=order)
            asked[own] = self.voltage(own)
            if asked[own] <= self._most:
                return own
        return min(asked, key=asked.__getitem__)

    def possible(self, leg: Leg) -> Leg:
        """A leg in a time in which some plain profile can be followed.

        Args:
            leg: The leg in the time that is asked for.

        Returns:
            The leg, `paced`, in that time, or in as many steps of `STRETCH` more as the drives
            need.
        """
        own = self.paced(dataclasses.replace(leg, time=max(leg.time, SHORTEST)))
        while self.voltage(own) > self._most and own.time < LONGEST:
            own = self.paced(dataclasses.replace(own, time=own.time * STRETCH))
        return own
