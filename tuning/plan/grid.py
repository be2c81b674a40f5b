"""A leg's intervals: what a plan is computed on, all of it but the unknowns."""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from tuning.plan.feedforward import Motion
from tuning.plan.pace import Pace
from tuning.plan.profile import Basis, plain_motion, spline_basis, with_deviation

REST = 0.08
"""Time at the end of a leg in which the lower carriage already holds, and everything is to
be at rest: the upper carriage takes some 60 ms of it for its last millimetre [s]."""
SPLINE_WIDTH = 0.11
"""Time between the knots of the lower carriage's deviation [s]."""


class Grid(NamedTuple):
    """A leg's plain profile and splines at its intervals."""

    instants: Motion
    """The plain profile at the beginnings of the intervals."""
    middles: Motion
    """The plain profile in the middles of the intervals."""
    ends: Float[Array, "intervals 2"]
    """The plain profile's position at the ends of the intervals [m]."""
    basis: tuple[Basis, Basis]
    """The splines at the beginnings and in the middles."""
    period: Float[Array, ""]
    """Length of the intervals [s]."""


def grid(
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    *,
    pace: Pace,
    steps: int,
    hold: int,
) -> Grid:
    """The grid of a leg.

    Args:
        start: First position of the end-effector [m].
        end: Last position [m].
        pace: Time and plain profile of the leg.
        steps: Intervals in the leg.
        hold: Intervals after it.

    Returns:
        The grid.
    """
    leg_time, moving = pace.leg_time, pace.leg_time - REST
    period = leg_time / steps
    begins = period * np.arange(steps + hold)
    # One more instant than intervals: the profile's own end is exact.
    instants = [begins, begins + period / 2, begins + period]
    whole, shorter = (
        functools.partial(
            plain_motion,
            jnp.asarray(start),
            jnp.asarray(end),
            leg_time=jnp.asarray(time),
            order=pace.order,
        )
        for time in (leg_time, moving)
    )
    at_begin, at_middle = (
        # The height has nothing to wait for: it takes the whole leg.
        jax.tree.map(
            lambda x, y: jnp.stack([x[:, 0], y[:, 1]], axis=1),
            shorter(time=jnp.asarray(time)),
            whole(time=jnp.asarray(time)),
        )
        for time in instants[:2]
    )
    ends = whole(time=jnp.asarray(instants[2])).position
    splines = max(round(moving / SPLINE_WIDTH), 4)
    curves = tuple(spline_basis(moving, time, splines=splines) for time in instants[:2])
    return Grid(at_begin, at_middle, ends, curves, jnp.asarray(period))


def led(on: Grid, coefficients: Float[Array, " splines"]) -> tuple[Motion, Motion]:
    """The commanded motion at the intervals' beginnings and middles.

    Args:
        on: The grid.
        coefficients: Coefficients of the splines [m].

    Returns:
        Both.
    """
    first, second = on.basis
    return (
        with_deviation(on.instants, first, coefficients),
        with_deviation(on.middles, second, coefficients),
    )
