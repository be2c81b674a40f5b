"""A leg that is to be planned, and the instants that its plan is computed on."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from scdpr_jax.robot.fields import si
from tuning.plan.profile import Course, Moment, plain_moments, spline_moments, spline_sums

REST = 0.08
"""Time at the end of a leg in which the lower carriage already holds, and everything is to
be at rest: the upper carriage takes some 60 ms of it for its last millimetre [s]."""
SPLINE_WIDTH = 0.06
"""Time between the knots of the lower carriage's deviation [s]."""
FEWEST_SPLINES, MOST_SPLINES = 6, 40
"""Fewest and most splines of a leg; longer legs have wider ones."""


@dataclasses.dataclass(frozen=True)
class Leg:
    """A leg from rest to rest."""

    start: tuple[float, float]
    """Where the end-effector rests, $[x_e, y_e]$ [m]."""
    end: tuple[float, float]
    """Where it is to rest, in line [m]."""
    time: float = dataclasses.field(metadata=si("s"))
    """Time that it takes [s]."""
    slope: float = dataclasses.field(default=0.0, metadata=si("1"))
    """Slope of the line between the carriages at its begin, $(q_3 - q_4) / H$ [1]."""
    order: float = 2.0
    """Order of its plain profile's `pace`."""

    @property
    def moving(self) -> float:
        """Time until the lower carriage holds [s]."""
        return self.time - REST

    @property
    def splines(self) -> int:
        """How many splines its deviation has."""
        return min(max(round(self.moving / SPLINE_WIDTH), FEWEST_SPLINES), MOST_SPLINES)

    @property
    def course(self) -> Course:
        """Its plain profile of lower carriage and height."""
        (x, y), durations = self.start, (self.moving, self.time)
        begin = (x + self.slope * y, y)
        return Course(*map(np.array, (begin, self.end, durations, self.order)))


class Places(NamedTuple):
    """A leg's plain profile and its splines at some instants, with two derivatives each."""

    plain: Float[np.ndarray, "3 n 2"]
    """The plain profile of lower carriage and height [m; m/s; m/s²]."""
    splines: Float[np.ndarray, "3 n splines"]
    """The splines [1; 1/s; 1/s²]."""


def places(leg: Leg, time: Float[np.ndarray, " instants"]) -> Places:
    """A leg at some instants.

    Args:
        leg: The leg.
        time: The instants [s].

    Returns:
        Plain profile and splines.
    """
    return Places(
        np.stack(plain_moments(leg.course, time)),
        spline_moments(time, duration=leg.moving, count=leg.splines),
    )


def led(
    leg: Leg, coefficients: Float[np.ndarray, " splines"], time: Float[np.ndarray, " instants"]
) -> Moment:
    """The motion of lower carriage and height at some instants.

    Args:
        leg: The leg.
        coefficients: Of its splines [m].
        time: The instants [s].

    Returns:
        Positions, velocities and accelerations, a row for each instant [m; m/s; m/s²].
    """
    moved = np.stack(plain_moments(leg.course, time))
    moved[..., 0] += spline_sums(coefficients, time, duration=leg.moving)
    return Moment(*moved)
