"""A leg on the steps that its misfit is computed on."""

import dataclasses
import functools

import numpy as np
from jaxtyping import Float, Int

from scdpr_jax.engines.led_stepping import Lead, thirds
from tuning.plan.leg import Leg, Places, places
from tuning.plan.profile import Moment, pace_values

TRACKED, COMMANDED = 4, 2
"""Every how many steps the profile, and the commands, are looked at."""
JUST_BEFORE = 1 - 1e-9
"""Share of the time of its motion that the lower carriage still moves at [1]."""


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
    def _halves(self) -> Places:
        """The leg at every half step."""
        return places(self.leg, self.duration / 2 * np.arange(2 * self.steps + 1))

    @functools.cached_property
    def _begins(self) -> Places:
        """The leg at the beginnings of the steps."""
        return Places(*(own[:, :-1:2] for own in self._halves))

    @functools.cached_property
    def _plain(self) -> Float[np.ndarray, "steps 3 2"]:
        """The plain profile of lower carriage and height in the steps [m]."""
        return thirds(self._halves.plain[0])

    @functools.cached_property
    def _splines(self) -> Float[np.ndarray, "steps 3 splines"]:
        """The splines in the steps [1]."""
        return thirds(self._halves.splines[0])

    @functools.cached_property
    def moving(self) -> int:
        """Steps that begin before the lower carriage holds."""
        return int(self.leg.moving / self.duration + 0.5)

    @property
    def tracked(self) -> slice:
        """The steps at which the profile is looked at."""
        return slice(0, self.moving, TRACKED)

    @functools.cached_property
    def commanded(self) -> Int[np.ndarray, " instants"]:
        """The steps in which commands are looked at."""
        last = int(self.leg.moving / self.duration)
        return np.append(np.arange(0, self.moving, COMMANDED), last)

    @functools.cached_property
    def looked_at(self) -> Places:
        """The leg at `commanded`: as these steps begin, and just before it holds.

        There the splines' acceleration ends with a jump, which lies between two steps.
        """
        time = self.duration * self.commanded
        time[-1] = self.leg.moving * JUST_BEFORE
        return places(self.leg, time)

    @functools.cached_property
    def looked_aside(self) -> Moment:
        """What each spline does to the motion at `commanded`, for every motion and robot."""
        return _aside(self.looked_at.splines)

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
        return np.ascontiguousarray(np.moveaxis(self._splines, 2, 0))

    @functools.cached_property
    def begun(self) -> Int[np.ndarray, " steps"]:
        """How many splines have begun by the end of each step."""
        first = np.argmax(np.any(self._splines != 0, axis=1), axis=0)
        return np.searchsorted(first, np.arange(self.steps), side="right")

    def lead(self, points: Float[np.ndarray, "motions splines"]) -> Lead:
        """Where the fitted robot is led.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            A row for each step, behind axes of motions and of robots.
        """
        lower, height = np.moveaxis(self._plain, -1, 0)
        aside = points @ self._splines.reshape(-1, points.shape[1]).T
        return Lead(lower + aside.reshape(-1, 1, *lower.shape), height[None, None])

    def velocity(
        self, points: Float[np.ndarray, "motions splines"]
    ) -> Float[np.ndarray, "motions 1 steps 2"]:
        """Velocities of lower carriage and height as the steps begin.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            The velocities [m/s].
        """
        return self._begins.velocity(points)[:, None]

    def commanded_motion(self, points: Float[np.ndarray, "motions splines"]) -> Moment:
        """The same at `commanded`.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            Positions, velocities and accelerations [m; m/s; m/s²].
        """
        return Moment(*(own[:, None] for own in self.looked_at.motion(points)))


def _aside(splines: Float[np.ndarray, "3 n splines"]) -> Moment:
    """Tangents of lower carriage and height, which the splines leave alone."""
    pairs = (np.stack([own.T, np.zeros_like(own.T)], axis=-1) for own in splines)
    return Moment(*(np.ascontiguousarray(own[None, None]) for own in pairs))
