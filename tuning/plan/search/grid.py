"""A leg on the steps that its misfit is computed on."""

import dataclasses
import functools

import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Lead
from tuning.plan.leg import Leg, Places, places
from tuning.plan.profile import Moment, pace_values

TRACKED, COMMANDED = 4, 2
"""Every how many steps the profile, and the commands, are looked at."""


@dataclasses.dataclass(frozen=True, eq=False)
class Grid:
    """A leg in even steps."""

    leg: Leg
    steps: int
    """Steps in the leg."""

    @property
    def duration(self) -> float:
        """Length of a step [s]."""
        return self.leg.time / self.steps

    @functools.cached_property
    def halves(self) -> Places:
        """The leg at every half step."""
        return places(self.leg, self.duration / 2 * np.arange(2 * self.steps + 1))

    @functools.cached_property
    def begins(self) -> Places:
        """The leg at the beginnings of the steps."""
        return self.halves.rows(slice(0, 2 * self.steps, 2))

    @functools.cached_property
    def moving(self) -> int:
        """Steps that begin before the lower carriage holds."""
        return int(self.leg.moving / self.duration + 0.5)

    @property
    def tracked(self) -> slice:
        """The steps at which the profile is looked at."""
        return slice(0, self.moving, TRACKED)

    @property
    def commanded(self) -> slice:
        """The steps at which commands are looked at."""
        return slice(0, self.moving, COMMANDED)

    @functools.cached_property
    def plain_way(self) -> Float[np.ndarray, " tracked"]:
        """Where the end-effector is by the plain profile, at `tracked` [m]."""
        time = self.duration * np.arange(0, self.moving, TRACKED)
        begin, end = self.leg.start[0], self.leg.end[0]
        share = pace_values(time, duration=self.leg.time, order=self.leg.order)
        return begin + (end - begin) * share

    @functools.cached_property
    def along(self) -> Float[np.ndarray, "splines steps 3"]:
        """What each spline does to where the lower carriage is led."""
        return np.ascontiguousarray(np.moveaxis(_thirds(self.halves.splines.value), 2, 0))

    @functools.cached_property
    def aside(self) -> Moment:
        """What each spline does to the motion at the beginnings, behind an axis of robots."""
        return Moment(
            *(
                np.ascontiguousarray(np.stack([own.T, np.zeros_like(own.T)], axis=-1)[None])
                for own in self.begins.splines
            )
        )

    @functools.cached_property
    def _height(self) -> Float[np.ndarray, "1 steps 3"]:
        return _thirds(self.halves.plain.value[:, 1])[None]

    def lead(self, point: Float[np.ndarray, " splines"]) -> Lead:
        """Where the fitted robot is led.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            A row for each step, behind an axis of robots.
        """
        return Lead(_thirds(self.halves.lower(point))[None], self._height)

    def motion(self, point: Float[np.ndarray, " splines"]) -> Moment:
        """The led motion at the beginnings of the steps, behind an axis of robots.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            Positions, velocities and accelerations [m; m/s; m/s²].
        """
        return Moment(*(own[None] for own in self.begins.motion(point)))

    def commanded_motion(self, point: Float[np.ndarray, " splines"]) -> Moment:
        """The same at `commanded`.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            Positions, velocities and accelerations [m; m/s; m/s²].
        """
        looked_at = self.begins.rows(self.commanded)
        return Moment(*(own[None] for own in looked_at.motion(point)))


def _thirds(halves: Float[np.ndarray, "points ..."]) -> Float[np.ndarray, "steps 3 ..."]:
    """Beginning, middle and end of each step."""
    return np.stack([halves[:-1:2], halves[1::2], halves[2::2]], axis=1)
