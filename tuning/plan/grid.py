"""A leg's intervals: what a plan is computed on, all of it but the unknowns."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.native import kept_jit
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
    middles = begins + period / 2
    times = np.array([leg_time, moving])
    at_begin, at_middle = (
        Motion(*_held(start, end, times, time, pace.order)) for time in (begins, middles)
    )
    # One more instant than intervals: the profile's own end is exact.
    ends, *_ = _held(start, end, times[[0, 0]], begins + period, pace.order)
    splines = max(round(moving / SPLINE_WIDTH), 4)
    curves = tuple(spline_basis(moving, time, splines=splines) for time in (begins, middles))
    return Grid(at_begin, at_middle, ends, curves, jnp.asarray(period))


@kept_jit
def _held(
    start: Float[Array, "2"],
    end: Float[Array, "2"],
    leg_times: Float[Array, "2"],
    time: Float[Array, " instants"],
    order: int,
) -> list[Float[Array, "instants 2"]]:
    """Position, velocity and acceleration of the plain profile, and its own time for either.

    The height has nothing to wait for: it takes the whole leg.
    """
    height, across = (
        plain_motion(start, end, leg_time=leg_time, time=time, order=order)
        for leg_time in leg_times
    )
    return [
        jnp.stack([x[:, 0], y[:, 1]], axis=1)
        for x, y in zip(jax.tree.leaves(across), jax.tree.leaves(height), strict=True)
    ]


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
