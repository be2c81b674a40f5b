"""Legs planned while somebody moves the sliders, one at a time."""

import functools
import threading

from experiments.reports.show.asked_leg import AskedLeg
from experiments.studies.legs.planned_leg import Compared, compare
from scdpr_jax.robot.parameters import Robot
from tuning.plan.planning import Planned, Planner
from tuning.result.tuning import Tuning

_MOMENT = 0.9
"""How long one waits for a plan to come to its end [s]."""
_KEPT = 64
"""Plans that are kept: a page asks for the same one to show, to write and to draw."""


class Planning:
    """Plans of a tuning's robots."""

    def __init__(self, tuning: Tuning) -> None:
        """Nothing is planned yet.

        Args:
            tuning: The tuning, which has a fitted robot.
        """
        self._tuning = tuning
        self._one = threading.Lock()
        self._planner = functools.cache(self._new_planner)
        self._plan = functools.lru_cache(_KEPT)(self._new_plan)

    def robot(self, asked: AskedLeg) -> Robot:
        """The robot at the leg's setting."""
        return self._tuning.robot_at(asked.setting).robot

    def plan(self, asked: AskedLeg) -> Planned:
        """A leg's plan; whoever asks meanwhile waits.

        Args:
            asked: The leg.

        Returns:
            The plan.

        Raises:
            ValueError: If it is no leg.
        """
        with self._one:
            return self._plan(asked)

    def compared(self, asked: AskedLeg) -> Compared:
        """A leg's plan beside the plain profile, simulated on robots as they might be.

        Args:
            asked: The leg.

        Returns:
            The runs.
        """
        with self._one:
            made = self._plan(asked)
            return compare(self.robot(asked), self._tuning.controller, made)

    def close(self) -> None:
        """Waits a moment for what is being planned; nothing more is."""
        self._one.acquire(timeout=_MOMENT)

    def _new_planner(self, setting: float) -> Planner:
        return Planner(self._tuning.robot_at(setting).robot, self._tuning.controller)

    def _new_plan(self, asked: AskedLeg) -> Planned:
        return self._planner(asked.setting)(asked.wanted)
