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

    @property
    def height(self) -> Float[np.ndarray, "steps 3"]:
        """The height in the steps, which no spline moves [m]."""
        return np.ascontiguousarray(self._plain[..., 1])

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
        """What each spline does to the motion at `commanded`, behind an axis of robots."""
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

    @functools.cached_property
    def led(self) -> tuple[Float[np.ndarray, " all"], Float[np.ndarray, "all splines"]]:
        """What a `Way` shows of the lower carriage: the plain profile's, and the splines'."""
        begins, looked = self._begins, self.looked_at
        plain = (self._plain[..., 0], begins.plain[1, :, 0], looked.plain[..., 0])
        splines = (self._splines, begins.splines[1], looked.splines)
        return (
            np.concatenate([own.ravel() for own in plain]),
            np.concatenate([own.reshape(-1, self.leg.splines) for own in splines]),
        )


class Way:
    """Where motions lead the robots: one after the other, in the same arrays."""

    def __init__(self, grid: Grid):
        """The plain profile's.

        Args:
            grid: The leg on its steps.
        """
        self._plain, self._splines = grid.led
        self._all = self._plain.copy()
        steps, instants = grid.steps, grid.commanded.size
        thirds_, velocity, looked = np.split(self._all, [3 * steps, 4 * steps])
        self.lead = Lead(thirds_.reshape(1, steps, 3), grid.height[None])
        """Where the fitted robot is led in each step."""
        self.velocity = velocity[None]
        """Velocities of the lower carriage as the steps begin [m/s]."""
        self._looked = looked.reshape(3, instants)
        self._moments = grid.looked_at.plain.copy()
        self.commanded = Moment(*(own[None] for own in self._moments))
        """Motion of lower carriage and height at `Grid.commanded`."""

    @property
    def lower(self) -> Float[np.ndarray, " instants"]:
        """Where the lower carriage is at `Grid.commanded` [m]."""
        return self._looked[0]

    def __call__(self, point: Float[np.ndarray, " splines"]) -> None:
        """Lead along another motion.

        Args:
            point: Coefficients of the splines [m].
        """
        np.matmul(self._splines, point, out=self._all)
        self._all += self._plain
        self._moments[..., 0] = self._looked


def _aside(splines: Float[np.ndarray, "3 n splines"]) -> Moment:
    """Tangents of lower carriage and height, which the splines leave alone."""
    pairs = (np.stack([own.T, np.zeros_like(own.T)], axis=-1) for own in splines)
    return Moment(*(np.ascontiguousarray(own[None]) for own in pairs))
