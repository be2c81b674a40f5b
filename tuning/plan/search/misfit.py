"""What is wrong with a motion, in residuals of one unit each: what a search lowers."""

import dataclasses
import functools
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from scdpr_jax import native
from scdpr_jax.engines.led_stepping import Lead, Undriven
from scdpr_jax.numerics.merit import Merit, Normal
from tuning.plan.led.arrival import Arrival, Goal
from tuning.plan.led.following import Arriving, Followed, Followers, Inverted, Leader
from tuning.plan.led.servo import Deviation, Led
from tuning.plan.leg import Leg
from tuning.plan.search.grid import Grid
from tuning.plan.search.scenarios import Scenarios, goals, shifts, starts

VIBRATION = 0.067e-3
"""Amplitude of a mode as the leg ends that counts as one [m]."""
RESTING = 0.158e-3
"""Distance of the place of rest from the target that counts as one [m]."""
SLIDING = 20e-3
"""Velocity of the upper carriage as the leg ends that counts as one [m/s]."""
TRACKING = 0.5
"""Distance from the plain profile during the leg that counts as one [m]."""
VOLTAGE_SHARE = 0.85
"""Share of the voltage limit beyond which commands cost; the rest is the PD's [1]."""
VOLTAGE = 0.5
"""Excess of a command that counts as one [V]."""
ROUGHNESS = 2.0
"""Second difference of the splines' coefficients that counts as one [m]."""
OUTSIDE = 1e-3
"""How far out of the frame the lower carriage counts as one [m]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Tried(Merit):
    """The misfit of a motion, without a model."""

    point: Float[np.ndarray, " splines"]
    """Coefficients of the splines [m]."""
    cost: float
    """The sum of squared residuals."""


@dataclasses.dataclass(frozen=True, eq=False)
class Misfit:
    """A leg with the robots that it is planned for, on a grid of steps.

    Motions are looked at side by side: they fill a processor's vectors where robots don't.
    """

    leg: Leg
    robots: Scenarios
    """The robots, the one whose dynamics are inverted first."""
    leader: Leader
    """That one."""
    followers: Followers | None
    """The others, under its feed-forward; None if there are none."""
    arriving: Arriving
    """All of them."""
    steps: int
    """Steps in the leg."""

    @property
    def duration(self) -> float:
        """Length of a step [s]."""
        return self.leg.time / self.steps

    @functools.cached_property
    def grid(self) -> Grid:
        """The leg on the steps."""
        return Grid(self.leg, self.steps)

    @functools.cached_property
    def _leading(self) -> native.Runs:
        return self.leader.steps(self.duration)

    @functools.cached_property
    def _following(self) -> native.Runs:
        return self.followers.steps(self.duration)

    @functools.cached_property
    def goals(self) -> Goal:
        """Where the robots are to be."""
        return goals(self.robots, self.leg)

    @functools.cached_property
    def _starts(self) -> tuple[Undriven, Undriven]:
        """Where the first one begins, and where the others do."""
        every = starts(self.robots, self.leg)
        first, others = (
            Undriven(*(part[:, rows] for part in every)) for rows in (slice(1), slice(1, None))
        )
        return first, others

    @functools.cached_property
    def _shifts(self) -> Float[np.ndarray, "others 1 1"]:
        return shifts(self.robots, self.leg)[1:, None, None]

    @functools.cached_property
    def limit(self) -> float:
        """Command beyond which there is a residual [V]."""
        return VOLTAGE_SHARE * float(self.robots.robot.drive.voltage_limit[0])

    @functools.cached_property
    def guide(self) -> tuple[float, float]:
        """Between which places the lower carriage fits into the frame [m]."""
        robot = self.robots.robot
        half = float(robot.lower_carriage.width[0]) / 2
        return half, float(robot.frame.width[0]) - half

    def __call__(self, points: Sequence[Float[np.ndarray, " splines"]]) -> list[Tried]:
        """The misfits of motions, without a model.

        Args:
            points: Coefficients of their splines [m].

        Returns:
            A merit for each.
        """
        return list(map(Tried, points, map(float, self.costs(np.stack(points)))))

    def derived(self, motions: Sequence[Tried]) -> list[Normal]:
        """The misfits of motions with their Gauss–Newton models.

        Args:
            motions: The motions.

        Returns:
            Their normal equations.
        """
        rows = self.rows(np.stack([own.point for own in motions]))
        products = np.swapaxes(rows, 1, 2) @ rows
        return [
            Normal(own.cost, product[:-1, -1], product[:-1, :-1])
            for own, product in zip(motions, products, strict=True)
        ]

    def run(self, points: Float[np.ndarray, "motions splines"]) -> tuple[Inverted, Followed]:
        """What the robots do.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            What the one does whose dynamics are inverted, and all of them.
        """
        lead, velocity = self.grid.lead(points), self.grid.velocity(points)
        first, others = self._starts
        own = self.leader.follow(self._leading, first, lead, velocity)
        if self.followers is None:
            return own, own.run
        led = self._led(lead, velocity, own.force)
        return own, _joined(own.run, self.followers.follow(self._following, others, led))

    def commands(
        self, own: Inverted, points: Float[np.ndarray, "motions splines"]
    ) -> Float[np.ndarray, "motions n 2"]:
        """Commands of the robot whose dynamics are inverted.

        Args:
            own: What it does.
            points: Coefficients of the splines [m].

        Returns:
            The commands where they are looked at [V].
        """
        positions = own.positions[:, :, self.grid.commanded]
        return self.leader.commands(positions, self.grid.commanded_motion(points))

    def costs(
        self, points: Float[np.ndarray, "motions splines"]
    ) -> Float[np.ndarray, " motions"]:
        """The sums of squared residuals.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            A sum for each motion [1].
        """
        own, run = self.run(points)
        parts = [
            *self._arrived(self.arriving(run, self.goals)),
            self._tracked(run.place[..., self.grid.tracked] - self.grid.plain_way),
            self._excess(self.commands(own, points)) / VOLTAGE,
            self._outside(points)[0] / OUTSIDE,
            points @ roughness(points.shape[1]).T,
        ]
        flat = (part.reshape(len(points), -1) for part in parts)
        return sum(np.vecdot(part, part) for part in flat)

    def rows(
        self, points: Float[np.ndarray, "motions splines"]
    ) -> Float[np.ndarray, "motions residuals splines+1"]:
        """Derivatives of the residuals, each with its residual behind.

        Args:
            points: Coefficients of the splines [m].

        Returns:
            A row for each residual.
        """
        grid = self.grid
        lead, velocity = grid.lead(points), grid.velocity(points)
        first, others = self._starts
        own, slopes = self.leader.follow_linearised(
            self._leading, first, lead, velocity, along=grid.along, begun=grid.begun
        )
        run, along = _looked_at(own.run, grid), _looked_at(slopes.run, grid)
        if self.followers is not None:
            pulled = np.moveaxis(slopes.force, -1, 2)
            more, their = self.followers.follow_linearised(
                self._following,
                others,
                self._led(lead, velocity, own.force),
                along=(grid.along, pulled),
                begun=grid.begun,
            )
            run = _joined(run, _looked_at(more, grid))
            along = _joined(along, _looked_at(their, grid))
        ends, endings = self.arriving.linearised(run, self.goals, along=along)
        outside, aside = self._outside(points)
        second = roughness(points.shape[1])
        return _in_rows(
            points.shape,
            [
                *zip(self._arrived(ends), self._arrived(endings), strict=True),
                (self._tracked(run.place - grid.plain_way), self._tracked(along.place)),
                *self._commanded(points, own, slopes.positions),
                (outside / OUTSIDE, aside / OUTSIDE),
                (points @ second.T, second[None]),
            ],
        )

    def _led(
        self,
        lead: Lead,
        velocity: Float[np.ndarray, "motions 1 steps 2"],
        force: Float[np.ndarray, "motions 1 steps"],
    ) -> Led:
        """What the others are told."""
        return Led(Lead(lead.lower + self._shifts, lead.height), velocity[..., 0], force)

    def _arrived(self, ends: Arrival) -> list[np.ndarray]:
        weight, resting = self.robots.weight, self.robots.resting
        return [
            _by_robot(weight / VIBRATION, ends.vibration),
            _by_robot(weight / SLIDING, ends.sliding),
            _by_robot(resting / RESTING, ends.rest),
        ]

    def _tracked(self, way: np.ndarray) -> np.ndarray:
        return _by_robot(self.robots.weight / TRACKING, way)

    def _excess(
        self, volts: Float[np.ndarray, "motions n 2"]
    ) -> Float[np.ndarray, "motions n 2"]:
        """Commands beyond what is left to the PD [V]."""
        return np.maximum(np.abs(volts) - self.limit, 0.0)

    def _commanded(
        self,
        points: Float[np.ndarray, "motions splines"],
        own: Inverted,
        slopes: Float[np.ndarray, "motions 1 steps 3 splines"],
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residuals of commands with their derivatives; nothing where there are none."""
        if not np.any(self._excess(self.commands(own, points))):
            return []
        rows, motion = self.grid.commanded, self.grid.commanded_motion(points)
        along = (np.moveaxis(slopes[:, :, rows], -1, 2), self.grid.looked_aside)
        volts, slope = self.leader.commands_linearised(
            own.positions[:, :, rows], motion, along=along
        )
        excess = self._excess(volts)
        return [
            (excess / VOLTAGE, slope * (np.sign(volts) * (excess > 0) / VOLTAGE)[..., None])
        ]

    def _outside(
        self, points: Float[np.ndarray, "motions splines"]
    ) -> tuple[Float[np.ndarray, "motions n"], Float[np.ndarray, "motions n splines"]]:
        """How far the lower carriage is led out of the frame, with derivatives [m; 1]."""
        (low, high), looked_at = self.guide, self.grid.looked_at
        place = looked_at.lower(points)
        out = np.maximum(np.maximum(low - place, place - high), 0.0)
        side = np.where(out > 0, np.sign(place - low), 0.0)
        return out, side[..., None] * looked_at.splines[0]


def _by_robot(factor: Float[np.ndarray, " robots"], own: np.ndarray) -> np.ndarray:
    return own * factor.reshape(-1, *(1,) * (own.ndim - 2))


def _joined(first: Followed, others: Followed) -> Followed:
    """A run of all robots."""

    def both(own: np.ndarray, their: np.ndarray) -> np.ndarray:
        every = np.broadcast_to(own, (len(their), *own.shape[1:]))
        return np.concatenate([every, their], axis=1)

    return Followed(
        Undriven(*map(both, first.end, others.end)),
        Deviation(*map(both, first.aside, others.aside)),
        both(first.place, others.place),
    )


def _in_rows(
    shape: tuple[int, int], pairs: Sequence[tuple[np.ndarray, np.ndarray]]
) -> Float[np.ndarray, "motions residuals columns"]:
    """Residuals with their derivatives by all splines, one behind the other."""
    motions, count = shape
    sizes = [value[0].size for value, _ in pairs]
    rows, last = np.empty((motions, sum(sizes), count + 1)), 0
    for size, (value, slope) in zip(sizes, pairs, strict=True):
        here, last = rows[:, last : last + size], last + size
        here[..., :count] = slope.reshape(-1, size, count)
        here[..., count] = value.reshape(-1, size)
    return rows


def _looked_at(run: Followed, grid: Grid) -> Followed:
    """A run, or its derivatives, with the places that the profile is compared with."""
    return run._replace(place=run.place[:, :, grid.tracked])


@functools.cache
def roughness(count: int) -> Float[np.ndarray, "n splines"]:
    """Second differences of coefficients: what no robot minds is left smooth.

    Args:
        count: How many.

    Returns:
        The matrix that makes residuals of them [1/m].
    """
    return np.diff(np.eye(count), 2, axis=0) / ROUGHNESS
