"""A team led along a leg: what one motion after the other comes to, in the same arrays.

A search tries some two hundred motions of a leg in as many tenths of a second. So what their
runs read and write is laid out once.
"""

from collections.abc import Iterator
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Lead, Undriven
from scdpr_jax.native import Held, Runs, Slopes
from tuning.plan.led.servo import Deviation, Led
from tuning.plan.search.grid import Grid, Way
from tuning.plan.search.scenarios import goals, shifts, starts
from tuning.plan.search.team import Team

_STILL = Undriven(np.zeros((1, 1, 3)), np.zeros((1, 1, 3)))
_CALM = Deviation(np.zeros((1, 1)), np.zeros((1, 1)))
"""Tangents of a start that no spline moves."""


class Steps(NamedTuple):
    """Steps of a team along a leg."""

    first: Runs
    """Of the robot whose dynamics are inverted."""
    others: Runs | None
    """Of those under its feed-forward, if there are some."""


def steps_of(team: Team, grid: Grid) -> Steps:
    """Steps of a team along a leg.

    Args:
        team: The robots.
        grid: The leg on its steps.

    Returns:
        The steps, for rehearsals with slopes and without.
    """
    shifted = shifts(team.robots, grid.leg)[1:]
    return Steps(
        team.leader.steps(grid.duration),
        team.followers and team.followers.steps(grid.duration, shifted),
    )


class Rehearsal:
    """A team on a leg. What it shows is of the last motion that it was led along."""

    def __init__(self, team: Team, grid: Grid, steps: Steps, *, sloping: bool):
        """Nothing runs yet.

        Args:
            team: The robots.
            grid: The leg on its steps.
            steps: `steps_of` both.
            sloping: Whether derivatives by the coefficients of the splines are wanted, too,
                which everything that is called a slope has along its last axis.
        """
        self._team, self._grid, self._sloping = team, grid, sloping
        self.way = Way(grid)
        """Where they are led."""
        self._first = self._leading(steps.first)
        self._others = steps.others and self._following(steps.others)
        self._looked_at = np.empty((1, grid.commanded.size, 3))
        self._commanding = team.leader.commanding.held(
            (), (self._looked_at, self.way.commanded)
        )
        # What the others' ends come to goes behind the first one's.
        robots, splines = len(team.robots.weight), grid.leg.splines
        place, velocity, aside = shapes = _end_shapes(robots, 1)
        goal = jax.tree.map(lambda own: own[:, None], goals(team.robots, grid.leg))
        self._told = (Undriven(place, velocity), aside, goal)
        self._joined = [(to[:, 0], own) for to, own in zip(shapes, self._ends(), strict=True)]
        along = None
        if sloping:
            place, velocity, aside = shapes = _end_shapes(robots, splines, 1)
            along = Slopes((), (Undriven(place, velocity), aside, None))
            self._joined += [
                (to[:, :, 0], [np.moveaxis(part, -1, 1) for part in own])
                for to, own in zip(shapes, self._ends(slopes=True), strict=True)
            ]
        self._arriving = team.arriving.arrivals.held((), self._told, along=along)

    def _leading(self, steps: Runs) -> Held:
        """The robot whose dynamics are inverted."""
        grid, way, along = self._grid, self.way, None
        if self._sloping:
            along = Slopes(_STILL, (Lead(grid.along[None], None), None))
        start = Undriven(*(own[:1] for own in starts(self._team.robots, grid.leg)))
        return steps.held(start, (way.lead, way.velocity), along=along, begun=grid.begun)

    def _following(self, steps: Runs) -> Held:
        """The others, under what pulls at the first one."""
        team, grid, along = self._team, self._grid, None
        _, (_, force) = self._first.results
        if self._sloping:
            self._pulled = np.zeros((1, grid.leg.splines, grid.steps))
            moved = Led(Lead(grid.along[None], None), None, self._pulled)
            along = Slopes((_STILL, _CALM), moved)
        start = Undriven(*(own[1:] for own in starts(team.robots, grid.leg)))
        calm = np.zeros(len(start.position))
        return steps.held(
            (start, Deviation(calm, calm)),
            Led(self.way.lead, self.way.velocity, force),
            along=along,
            begun=grid.begun,
        )

    def _ends(self, *, slopes: bool = False) -> Iterator[list[np.ndarray]]:
        """Places, velocities and deviations as the leg ends, of the first one and the others.

        They are the runs' own arrays, or those of their derivatives.
        """
        first, *others = (
            own.slopes.carried if slopes else own.results[0]
            for own in (self._first, self._others)
            if own is not None
        )
        yield [first.position, *(own.position for own, _ in others)]
        yield [first.velocity, *(own.velocity for own, _ in others)]
        yield [np.zeros_like(first.position[:, 0]), *(aside.position for _, aside in others)]

    def __call__(self, point: Float[np.ndarray, " splines"]) -> None:
        """Lead the robots along another motion.

        Args:
            point: Coefficients of the splines [m].
        """
        self.way(point)
        self._first()
        if self._others is not None:
            if self._sloping:
                _, pulled = self._first.slopes.rows
                self._pulled[0] = pulled[0].T
            self._others()
        for to, parts in self._joined:
            np.concatenate(parts, out=to)
        self._arriving()
        _, (positions, _) = self._first.results
        self._looked_at[...] = positions[:, self._grid.commanded]
        self._commanding()

    @property
    def arrived(self) -> Float[np.ndarray, "robots 6"]:
        """What each robot does as the leg ends, `Arrival` in one row [m; m/s; m]."""
        return self._arriving.results[1][:, 0]

    @property
    def arrived_slopes(self) -> Float[np.ndarray, "robots 6 splines"]:
        """Its derivatives."""
        return self._arriving.slopes.rows[:, 0]

    @property
    def places(self) -> list[Float[np.ndarray, "robots tracked"]]:
        """Where the end-effectors are at `Grid.tracked`: the first one, the others [m]."""
        _, (positions, _) = self._first.results
        others = [] if self._others is None else [self._others.results[1]]
        return [own[:, self._grid.tracked] for own in (positions[:, :, 0], *others)]

    @property
    def place_slopes(self) -> list[Float[np.ndarray, "robots tracked splines"]]:
        """Its derivatives."""
        moved, _ = self._first.slopes.rows
        others = [] if self._others is None else [self._others.slopes.rows]
        return [own[:, self._grid.tracked] for own in (moved[:, :, 0], *others)]

    @property
    def commands(self) -> Float[np.ndarray, "instants 2"]:
        """Commands of the first one at `Grid.commanded` [V]."""
        return self._commanding.results[1][0]

    def command_slopes(self) -> Float[np.ndarray, "instants 2 splines"]:
        """Its derivatives, made anew: few motions ask for more than the drives have."""
        grid = self._grid
        moved, _ = self._first.slopes.rows
        aside = np.moveaxis(moved[:, grid.commanded], -1, 1)
        _, slopes = self._team.leader.commanding.linearised(
            (),
            (self._looked_at, self.way.commanded),
            along=Slopes((), (aside, grid.looked_aside)),
        )
        return slopes.rows[0]

    def vibrations(self) -> Float[np.ndarray, " robots"]:
        """Largest peak to peak of the end-effectors once both carriages hold [m]."""
        return self._team.arriving.vibrations((), self._told)[1][:, 0]


def _end_shapes(*behind: int) -> list[np.ndarray]:
    """Room for places, velocities and deviations."""
    return [np.zeros((*behind, 3)), np.zeros((*behind, 3)), np.zeros(behind)]
