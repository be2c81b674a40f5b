"""What is wrong with a motion, in residuals of one unit each: what a search lowers."""

import dataclasses
import functools
import math

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.merit import Merit
from tuning.plan.search.grid import Grid
from tuning.plan.search.rehearsal import Rehearsal, Steps, steps_of
from tuning.plan.search.team import Team

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


class Residuals:
    """The residuals of a motion, or a row of derivatives and the residual for each."""

    def __init__(self, robots: int, grid: Grid, *columns: int):
        """All zero.

        Args:
            robots: How many robots there are.
            grid: The leg on its steps.
            columns: Length of a row; nothing for residuals alone.
        """
        splines, instants = grid.leg.splines, grid.commanded.size
        shapes = (
            (robots, 6),
            (robots, grid.plain_way.size),
            (splines - 2,),
            (instants,),
            (instants, 2),
        )
        ends = np.cumsum([math.prod(own) for own in shapes])
        self._all = np.zeros((ends[-1], *columns))
        parts = (
            own.reshape(*shape, *columns)
            for own, shape in zip(np.split(self._all, ends[:-1]), shapes, strict=True)
        )
        self.arrived, self.tracked, self.rough, self.outside, self.excess = parts
        self._ends = ends

    def all(self, *, seldom: bool) -> np.ndarray:
        """All of them.

        Args:
            seldom: Whether the frame or the drives' voltage bounds something; those come last.

        Returns:
            A residual, or a row, after the other.
        """
        return self._all if seldom else self._all[: self._ends[2]]


@dataclasses.dataclass(frozen=True, eq=False)
class Misfit:
    """A leg with the robots that it is planned for."""

    team: Team
    """The robots."""
    grid: Grid
    """The leg on its steps."""

    @functools.cached_property
    def _steps(self) -> Steps:
        return steps_of(self.team, self.grid)

    @functools.cached_property
    def _rehearsal(self) -> Rehearsal:
        return Rehearsal(self.team, self.grid, self._steps, sloping=False)

    @functools.cached_property
    def _sloping(self) -> Rehearsal:
        return Rehearsal(self.team, self.grid, self._steps, sloping=True)

    @functools.cached_property
    def _residuals(self) -> Residuals:
        return Residuals(len(self.team.robots.weight), self.grid)

    @functools.cached_property
    def _rows(self) -> Residuals:
        splines = self.grid.leg.splines
        rows = Residuals(len(self.team.robots.weight), self.grid, splines + 1)
        rows.rough[:, :-1] = roughness(splines)
        return rows

    @functools.cached_property
    def _arriving_weight(self) -> Float[np.ndarray, "robots 6"]:
        weight, resting = self.team.robots.weight, self.team.robots.resting
        vibration = weight / VIBRATION
        return np.stack([*[vibration] * 4, weight / SLIDING, resting / RESTING], axis=1)

    @functools.cached_property
    def _tracking_weight(self) -> Float[np.ndarray, "robots 1"]:
        return self.team.robots.weight[:, None] / TRACKING

    @functools.cached_property
    def limit(self) -> float:
        """Command beyond which there is a residual [V]."""
        return VOLTAGE_SHARE * float(self.team.robots.robot.drive.voltage_limit[0])

    @functools.cached_property
    def guide(self) -> tuple[float, float]:
        """Between which places the lower carriage fits into the frame [m]."""
        robot = self.team.robots.robot
        half = float(robot.lower_carriage.width[0]) / 2
        return half, float(robot.frame.width[0]) - half

    def __call__(self, point: Float[np.ndarray, " splines"]) -> "Motion":
        """The misfit of a motion."""
        return Motion(point, self)

    def rehearsed(self, point: Float[np.ndarray, " splines"]) -> Rehearsal:
        """What the robots do.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            Their rehearsal, until the next motion is looked at.
        """
        self._rehearsal(point)
        return self._rehearsal

    def cost(self, point: Float[np.ndarray, " splines"]) -> float:
        """The sum of squared residuals.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            The sum [1].
        """
        into = self._residuals
        seldom = self._valued(self.rehearsed(point), point, into)
        residuals = into.all(seldom=seldom)
        return float(residuals @ residuals)

    def rows(
        self, point: Float[np.ndarray, " splines"]
    ) -> Float[np.ndarray, "residuals splines+1"]:
        """Derivatives of the residuals, each with its residual behind.

        Args:
            point: Coefficients of the splines [m].

        Returns:
            A row for each residual, until the next motion is looked at.
        """
        run, into, values = self._sloping, self._rows, self._residuals
        run(point)
        seldom = self._valued(run, point, values)
        into.all(seldom=seldom)[:, -1] = values.all(seldom=seldom)
        np.multiply(
            run.arrived_slopes, self._arriving_weight[..., None], out=into.arrived[..., :-1]
        )
        np.concatenate(run.place_slopes, out=into.tracked[..., :-1])
        into.tracked[..., :-1] *= self._tracking_weight[..., None]
        if seldom:
            side = np.sign(values.outside) / OUTSIDE
            into.outside[:, :-1] = side[:, None] * self.grid.looked_at.splines[0]
            side = np.sign(run.commands) * (values.excess > 0) / VOLTAGE
            into.excess[..., :-1] = run.command_slopes() * side[..., None]
        return into.all(seldom=seldom)

    def _valued(self, run: Rehearsal, point: np.ndarray, into: Residuals) -> bool:
        """Put the residuals there; whether the frame or the drives bound anything."""
        np.multiply(run.arrived, self._arriving_weight, out=into.arrived)
        np.concatenate(run.places, out=into.tracked)
        into.tracked -= self.grid.plain_way
        into.tracked *= self._tracking_weight
        np.matmul(roughness(point.size), point, out=into.rough)
        (low, high), place = self.guide, run.way.lower
        # Beyond the one end it is negative: its square doesn't mind, and its sign is the side.
        outside = np.minimum(place - low, 0.0) + np.maximum(place - high, 0.0)
        excess = np.maximum(np.abs(run.commands) - self.limit, 0.0)
        seldom = bool(outside.any() or excess.any())
        if seldom:
            into.outside[...], into.excess[...] = outside / OUTSIDE, excess / VOLTAGE
        return seldom


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
