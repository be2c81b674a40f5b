"""What is wrong with a motion, in residuals of one unit each: what a search lowers."""

import dataclasses
import functools

import numpy as np
from jaxtyping import Float

from scdpr_jax import native
from scdpr_jax.engines.led_stepping import Lead, Undriven
from scdpr_jax.numerics.merit import Merit
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
class Misfit:
    """A leg with the robots that it is planned for, on a grid of steps."""

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
            Undriven(*(part[rows] for part in every)) for rows in (slice(1), slice(1, None))
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

    def __call__(self, point: Float[np.ndarray, " splines"]) -> "Motion":
        """The misfit of a motion."""
        return Motion(point, self)

    def run(self, point: Float[np.ndarray, " splines"]) -> tuple[Inverted, Followed]:
        """What the robots do.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            What the one does whose dynamics are inverted, and all of them.
        """
        lead, velocity = self.grid.lead(point), self.grid.velocity(point)
        first, others = self._starts
        own = self.leader.follow(self._leading, first, lead, velocity)
        if self.followers is None:
            return own, own.run
        led = self._led(lead, velocity, own.force)
        return own, _joined(own.run, self.followers.follow(self._following, others, led))

    def commands(
        self, own: Inverted, point: Float[np.ndarray, " splines"]
    ) -> Float[np.ndarray, "n 2"]:
        """Commands of the robot whose dynamics are inverted.

        Args:
            own: What it does.
            point: Coefficients of the splines [m].

        Returns:
            The commands where they are looked at [V].
        """
        positions = own.positions[:, self.grid.commanded]
        return self.leader.commands(positions, self.grid.commanded_motion(point))

    def cost(self, point: Float[np.ndarray, " splines"]) -> float:
        """The sum of squared residuals.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            The sum [1].
        """
        own, run = self.run(point)
        parts = [
            *self._arrived(self.arriving(run, self.goals)),
            self._tracked(run.place[:, self.grid.tracked] - self.grid.plain_way),
            self._excess(self.commands(own, point)) / VOLTAGE,
            self._outside(point)[0] / OUTSIDE,
            roughness(point.size) @ point,
        ]
        return float(sum(part.reshape(-1) @ part.reshape(-1) for part in parts))

    def rows(
        self, point: Float[np.ndarray, " splines"]
    ) -> Float[np.ndarray, "residuals splines+1"]:
        """Derivatives of the residuals, each with its residual behind.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            A row for each residual.
        """
        grid = self.grid
        lead, velocity = grid.lead(point), grid.velocity(point)
        first, others = self._starts
        own, slopes = self.leader.follow_linearised(
            self._leading, first, lead, velocity, along=grid.along, begun=grid.begun
        )
        run, along = _looked_at(own.run, grid), _looked_at(slopes.run, grid)
        if self.followers is not None:
            pulled = np.moveaxis(slopes.force, -1, 1)
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
        outside, aside = self._outside(point)
        second = roughness(point.size)
        pairs = [
            *zip(self._arrived(ends), self._arrived(endings), strict=True),
            (
                self._tracked(run.place - grid.plain_way),
                self._tracked(along.place),
            ),
            *self._commanded(point, own, slopes.positions),
            (outside / OUTSIDE, aside / OUTSIDE),
            (second @ point, second),
        ]
        return np.concatenate(
            [
                np.concatenate([slope.reshape(-1, point.size), value.reshape(-1, 1)], axis=1)
                for value, slope in pairs
            ]
        )

    def _led(
        self,
        lead: Lead,
        velocity: Float[np.ndarray, "1 steps 2"],
        force: Float[np.ndarray, "1 steps"],
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

    def _excess(self, volts: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Commands beyond what is left to the PD [V]."""
        return np.maximum(np.abs(volts) - self.limit, 0.0)

    def _commanded(
        self, point: np.ndarray, own: Inverted, slopes: Float[np.ndarray, "1 steps 3 splines"]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residuals of commands with their derivatives; nothing where there are none."""
        rows, motion = self.grid.commanded, self.grid.commanded_motion(point)
        if not np.any(self._excess(self.commands(own, point))):
            return []
        along = (np.moveaxis(slopes[:, rows], -1, 1), self.grid.looked_aside)
        volts, slope = self.leader.commands_linearised(
            own.positions[:, rows], motion, along=along
        )
        excess = self._excess(volts)
        return [
            (excess / VOLTAGE, slope * (np.sign(volts) * (excess > 0) / VOLTAGE)[..., None])
        ]

    def _outside(
        self, point: Float[np.ndarray, " splines"]
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n splines"]]:
        """How far the lower carriage is led out of the frame, with derivatives [m; 1]."""
        (low, high), looked_at = self.guide, self.grid.looked_at
        place = looked_at.lower(point)
        out = np.maximum(np.maximum(low - place, place - high), 0.0)
        side = np.where(out > 0, np.sign(place - low), 0.0)
        return out, side[:, None] * looked_at.splines[0]


def _by_robot(factor: Float[np.ndarray, " robots"], own: np.ndarray) -> np.ndarray:
    return own * factor.reshape(-1, *(1,) * (own.ndim - 1))


def _joined(first: Followed, others: Followed) -> Followed:
    """A run of all robots."""

    def both(*parts: np.ndarray) -> np.ndarray:
        return np.concatenate(parts)

    return Followed(
        Undriven(*map(both, first.end, others.end)),
        Deviation(*map(both, first.aside, others.aside)),
        both(first.place, others.place),
    )


def _looked_at(run: Followed, grid: Grid) -> Followed:
    """A run, or its derivatives, with the places that the profile is compared with."""
    return run._replace(place=run.place[:, grid.tracked])


@dataclasses.dataclass(frozen=True, eq=False)
class Motion(Merit):
    """The misfit of a motion; its derivatives are made when they are asked for."""

    point: Float[np.ndarray, " splines"]
    """Coefficients of the splines [m]."""
    misfit: Misfit

    @functools.cached_property
    def cost(self) -> float:
        """The sum of squared residuals."""
        return self.misfit.cost(self.point)

    @functools.cached_property
    def normal(self) -> tuple[np.ndarray, np.ndarray]:
        """$J^T r$ and $J^T J$."""
        rows = self.misfit.rows(self.point)
        product = rows.T @ rows
        return product[:-1, -1], product[:-1, :-1]

    @property
    def gradient(self) -> Float[np.ndarray, " splines"]:
        """$J^T r$."""
        return self.normal[0]

    @property
    def matrix(self) -> Float[np.ndarray, "splines splines"]:
        """$J^T J$."""
        return self.normal[1]


@functools.cache
def roughness(count: int) -> Float[np.ndarray, "n splines"]:
    """Second differences of coefficients: what no robot minds is left smooth.

    Args:
        count: How many.

    Returns:
        The matrix that makes residuals of them [1/m].
    """
    return np.diff(np.eye(count), 2, axis=0) / ROUGHNESS
