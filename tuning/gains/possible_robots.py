"""Robots that gains and shapers have to serve: what a fit leaves open, and what none knows."""

import itertools
from collections.abc import Callable, Sequence

from scdpr_jax.legs.ensemble import Variation, vary
from scdpr_jax.robot.parameters import Robot

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


def possible_robots(fitted: Robot, drawn: Sequence[Robot] = ()) -> tuple[Robot, ...]:
    """Robots as they might be, with exact friction.

    Args:
        fitted: The fitted robot.
        drawn: Robots drawn from the fit's covariance; none where it isn't known.

    Returns:
        The fitted robot first, then one for each further variation, of the draws in turn.
    """
    others = itertools.cycle(drawn or (fitted,))
    return fitted, *(vary(next(others), each) for each in VARIATIONS[1:])
