"""Robots that a leg is planned for at once, ready to be led."""

from typing import NamedTuple

import jax
import numpy as np

from tuning.plan.led.following import Arriving, Followers, Leader
from tuning.plan.led.servo import Servo
from tuning.plan.search.scenarios import Scenarios


class Team(NamedTuple):
    """The robots."""

    robots: Scenarios
    """All of them, the one whose dynamics are inverted first."""
    leader: Leader
    """That one."""
    followers: Followers | None
    """The others, under its feed-forward; None if there are none."""
    arriving: Arriving
    """All of them."""


def team(leader: Scenarios, others: Scenarios | None, servo: Servo) -> Team:
    """Robots ready to be led.

    Args:
        leader: The one whose dynamics are inverted.
        others: Those that get its feed-forward; None for none.
        servo: The PD beside it.

    Returns:
        The team. Where its leader is to rest counts in full: for itself it is the fitted one.
    """
    first = leader._replace(resting=leader.weight)
    if others is None:
        return Team(first, Leader(leader.robot), None, Arriving(leader.robot))
    every = jax.tree.map(lambda *parts: np.concatenate(parts), first, others)
    followers = Followers(others.robot, servo)
    return Team(every, Leader(leader.robot), followers, Arriving(every.robot))
