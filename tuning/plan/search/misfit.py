"""What is wrong with a motion, in residuals of one unit each: what a search lowers."""

import dataclasses
import functools
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Lead, Undriven
from scdpr_jax.numerics.merit import Merit
from tuning.plan.led.arrival import Arrival, Goal
from tuning.plan.led.following import Arriving, Followed, Followers, Leader
from tuning.plan.led.servo import Led, Servo
from tuning.plan.leg import Leg
from tuning.plan.profile import Moment
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


class Group(NamedTuple):
    """Robots that are led in one way."""

    robots: Scenarios
    starts: Undriven
    goals: Goal
    shifts: Float[np.ndarray, " robots"]
    """How far each one's lower carriage is from where the leg has it [m]."""
    arriving: Arriving
    followers: Followers

    def led(self, lead: Lead, motion: Moment, forces: Float[np.ndarray, "1 n"]) -> Led:
        """What they are told.

        Args:
            lead: Where the fitted one is led.
            motion: Its motion at the beginnings of the steps, behind an axis of robots.
            forces: Its forces there [N].

        Returns:
            A row for each robot and step.
        """
        aside = self.shifts[:, None, None]
        return Led(Lead(lead.lower + aside, lead.height), motion.slope[..., 0], forces)

    def residuals(self, run: Followed, grid: Grid) -> list[np.ndarray]:
        """Residuals of a run.

        Args:
            run: The run.
            grid: The leg's.

        Returns:
            The residuals, an axis of robots first.
        """
        return [
            *self._arrived(self.arriving(run, self.goals)),
            self._tracked(run.positions[:, grid.tracked, 0] - grid.plain_way),
        ]

    def linearised(
        self, run: Followed, slopes: Followed, grid: Grid
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """The same with derivatives.

        Args:
            run: The run.
            slopes: Its derivatives.
            grid: The leg's.

        Returns:
            Residuals and their derivatives.
        """
        ends, their = self.arriving.linearised(run, self.goals, along=slopes)
        away = run.positions[:, grid.tracked, 0] - grid.plain_way
        return [
            *zip(self._arrived(ends), self._arrived(their), strict=True),
            (self._tracked(away), self._tracked(slopes.positions[:, grid.tracked, 0])),
        ]

    def _arrived(self, ends: Arrival) -> list[np.ndarray]:
        weight, resting = self.robots.weight, self.robots.resting
        return [
            _by_robot(weight / VIBRATION, ends.vibration),
            _by_robot(weight / SLIDING, ends.sliding),
            _by_robot(resting / RESTING, ends.rest),
        ]

    def _tracked(self, way: np.ndarray) -> np.ndarray:
        return _by_robot(self.robots.weight / TRACKING, way)


def _by_robot(factor: Float[np.ndarray, " robots"], own: np.ndarray) -> np.ndarray:
    return own * factor.reshape(-1, *(1,) * (own.ndim - 1))


@dataclasses.dataclass(frozen=True, eq=False)
class Misfit:
    """A leg with the robots that it is planned for, on a grid of steps."""

    leg: Leg
    fitted: Scenarios
    """The robot whose dynamics are inverted, alone."""
    others: Scenarios | None
    """Robots under its feed-forward; None for none."""
    servo: Servo
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
    def leader(self) -> Leader:
        """The robot whose dynamics are inverted, ready to be led."""
        return Leader(self.fitted.robot)

    @functools.cached_property
    def groups(self) -> tuple[Group, ...]:
        """The robots, ready to be led."""
        every = (self.fitted,) if self.others is None else (self.fitted, self.others)
        return tuple(
            Group(
                own,
                starts(own, self.leg),
                goals(own, self.leg),
                shifts(own, self.leg),
                Arriving(own.robot),
                Followers(own.robot, self.servo),
            )
            for own in every
        )

    @functools.cached_property
    def limit(self) -> float:
        """Command beyond which there is a residual [V]."""
        return VOLTAGE_SHARE * float(self.fitted.robot.drive.voltage_limit[0])

    @functools.cached_property
    def guide(self) -> tuple[float, float]:
        """Between which places the lower carriage fits into the frame [m]."""
        robot = self.fitted.robot
        half = float(robot.lower_carriage.width[0]) / 2
        return half, float(robot.frame.width[0]) - half

    def __call__(self, point: Float[np.ndarray, " splines"]) -> "Motion":
        """The misfit of a motion."""
        return Motion(point, self)

    def runs(self, point: Float[np.ndarray, " splines"]) -> tuple[Followed, ...]:
        """What the robots do: the fitted one, and the others.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            A run for each group.
        """
        lead, duration = self.grid.lead(point), self.duration
        first, *others = self.groups
        fitted = self.leader.follow(first.starts, lead, duration=duration)
        if not others:
            return (fitted,)
        motion = self.grid.motion(point)
        forces = self.leader.forces(fitted.positions, motion)
        led = others[0].led(lead, motion, forces)
        return fitted, others[0].followers.follow(others[0].starts, led, duration=duration)

    def runs_linearised(
        self, point: Float[np.ndarray, " splines"]
    ) -> tuple[tuple[Followed, Followed], ...]:
        """The same with derivatives.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            For each group its run and that one's derivatives.
        """
        lead, duration, grid = self.grid.lead(point), self.duration, self.grid
        first, *others = self.groups
        fitted = self.leader.follow_linearised(
            first.starts, lead, duration=duration, along=grid.along
        )
        if not others:
            return (fitted,)
        motion = grid.motion(point)
        coordinates = np.moveaxis(fitted[1].positions, -1, 1)
        forces, slopes = self.leader.forces_linearised(
            fitted[0].positions, motion, along=(coordinates, grid.aside.value)
        )
        led, own = others[0].led(lead, motion, forces), others[0]
        along = (grid.along, np.moveaxis(slopes, -1, 1))
        return fitted, own.followers.follow_linearised(
            own.starts, led, duration=duration, along=along
        )

    def cost(self, point: Float[np.ndarray, " splines"]) -> float:
        """The sum of squared residuals.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            The sum [1].
        """
        runs = self.runs(point)
        parts = [
            part
            for group, run in zip(self.groups, runs, strict=True)
            for part in group.residuals(run, self.grid)
        ]
        volts = self.leader.commands(
            runs[0].positions[:, self.grid.commanded], self.grid.commanded_motion(point)
        )
        parts += [
            self._excess(volts) / VOLTAGE,
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
        runs = self.runs_linearised(point)
        pairs = [
            pair
            for group, (run, slopes) in zip(self.groups, runs, strict=True)
            for pair in group.linearised(run, slopes, self.grid)
        ]
        outside, aside = self._outside(point)
        second = roughness(point.size)
        pairs += [
            *self._commanded(point, *runs[0]),
            (outside / OUTSIDE, aside / OUTSIDE),
            (second @ point, second),
        ]
        return np.concatenate(
            [
                np.concatenate([slope.reshape(-1, point.size), value.reshape(-1, 1)], axis=1)
                for value, slope in pairs
            ]
        )

    def _excess(self, volts: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Commands beyond what is left to the PD [V]."""
        return np.maximum(np.abs(volts) - self.limit, 0.0)

    def _commanded(
        self, point: np.ndarray, run: Followed, slopes: Followed
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residuals of commands with their derivatives; nothing where there are none."""
        rows, motion = self.grid.commanded, self.grid.commanded_motion(point)
        if not np.any(self._excess(self.leader.commands(run.positions[:, rows], motion))):
            return []
        along = (
            np.moveaxis(slopes.positions[:, rows], -1, 1),
            Moment(*(own[:, :, rows] for own in self.grid.aside)),
        )
        volts, slope = self.leader.commands_linearised(
            run.positions[:, rows], motion, along=along
        )
        excess = self._excess(volts)
        return [
            (excess / VOLTAGE, slope * (np.sign(volts) * (excess > 0) / VOLTAGE)[..., None])
        ]

    def _outside(
        self, point: Float[np.ndarray, " splines"]
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n splines"]]:
        """How far the lower carriage is led out of the frame, with derivatives [m; 1]."""
        (low, high), looked_at = self.guide, self.grid.begins.rows(self.grid.commanded)
        place = looked_at.lower(point)
        out = np.maximum(np.maximum(low - place, place - high), 0.0)
        side = np.where(out > 0, np.sign(place - low), 0.0)
        return out, side[:, None] * looked_at.splines.value


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
