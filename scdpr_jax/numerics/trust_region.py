"""A trust region: the way down by steps that a local model is trusted for.

A shaper that leaves least is a minimax: where the objective is a largest value, its minimum
lies on a kink, and no gradient vanishes there. So each step solves the convex problem that
its phasors, made linear, are over moves of a limited size, and the size alone says how far
the linear model is believed: it doubles where a step helped and shrinks to a quarter where
it didn't. A line search along a gradient would be simpler and stops at the first kink; a step
without a limit jumps to where the linear model is nonsense.
"""

import dataclasses
from collections.abc import Callable
from typing import TypeVar

Place = TypeVar("Place")


@dataclasses.dataclass(frozen=True)
class TrustRegion:
    """How large steps may be, and when a search ends."""

    steps: int
    """Steps that are tried at the most."""
    first: float = 0.03
    """Largest move of the first step [the moves' unit]."""
    least: float = 1e-6
    """Largest move below which the search ends [the moves' unit]."""
    worthwhile: float = 0.0
    """Share of the value that a step has to save for the search to go on [1]."""


def descend(
    step: Callable[[Place, float, float], tuple[Place, float]],
    place: Place,
    value: float,
    *,
    region: TrustRegion,
) -> tuple[Place, float]:
    """The best place that steps within a trust region lead to.

    Args:
        step: From a place, its value and the largest move to another place and its value.
        place: Where to begin.
        value: What is to fall, there; at 0 the search ends.
        region: Sizes of the steps, and their number.

    Returns:
        The place, and its value: never above the first one.

    Reference: A. R. Conn, N. I. M. Gould, P. L. Toint, "Trust-region methods", SIAM, 2000,
    doi:10.1137/1.9780898719857.
    """
    move = region.first
    for _ in range(region.steps):
        if value == 0 or move < region.least:
            break
        candidate, reached = step(place, value, move)
        if reached < value:
            saved = value - reached
            place, value, move = candidate, reached, 2 * move
            if saved < region.worthwhile * value:
                break
        else:
            move = move / 4
    return place, value
