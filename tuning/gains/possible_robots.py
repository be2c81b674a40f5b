"""Robots that gains and shapers have to serve: what a fit leaves open, and what none knows."""

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

from scdpr_jax.legs.ensemble import Variation, vary
from scdpr_jax.robot.parameters import Robot
from tuning.regions.cells import Cell, robot_in

Draws = Callable[[float], Sequence[Robot]]
"""From a nominal pretension [N] to robots as the fit's covariance leaves them possible."""

VARIATIONS = (
    Variation(),
    Variation(tension=1.015),
    Variation(friction=1.15),
    Variation(tension=0.985),
    Variation(friction=0.85),
)
"""How a rig differs from its fit all the same: friction changes from day to day and along a
guide, and a model's error isn't in its covariance."""


class PossibleRobot(NamedTuple):
    """A robot as it might be."""

    drawn: Robot
    """The fitted robot, or one that its covariance leaves possible."""
    variation: Variation
    """How it differs from that."""

    def inside(self, cell: Cell) -> Robot:
        """The robot where a cell's frequency was measured.

        What varies does so about the measured frequency, which would hide it otherwise.

        Args:
            cell: The cell.

        Returns:
            The robot.
        """
        return vary(robot_in(cell, self.drawn), self.variation)


def possible_robots(fitted: Robot, drawn: Sequence[Robot] = ()) -> tuple[PossibleRobot, ...]:
    """Robots as they might be.

    Args:
        fitted: The fitted robot, with exact friction.
        drawn: Robots drawn from the fit's covariance, likewise; none where it isn't known.

    Returns:
        The fitted robot first, then one for each further variation, of the draws in turn.
    """
    others = itertools.cycle(drawn or (fitted,))
    return (
        PossibleRobot(fitted, VARIATIONS[0]),
        *(PossibleRobot(next(others), each) for each in VARIATIONS[1:]),
    )
