"""Runs side by side, each a fit of its own: misfits, and the steps that lower them."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PyTree

from identification.fit.residuals import encoder_residuals
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.numerics.batches import in_chunks
from scdpr_jax.numerics.levenberg_marquardt import Damping, damped_step
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import rest

Result = TypeVar("Result")

LANES, FEW = 32, 8
"""Fits side by side, and of the last ones that go on: a chunk is filled up."""

CONVERGED = 1e-3
"""Decrease of the sum of squares that a step still promises, below which a lane is done [1]."""

DIVERGED = 2.0
"""Mean squared residual over which a lane that came to rest isn't at its minimum [1]."""


DAMPING = Damping(first=1e-2, least=0.0)
"""Damping of the last stage."""
REGULAR = 1e-9
"""Damping that keeps what can't be told apart from breaking the solution [1]."""
MOST_DAMPED = 1e4
"""Damping at which a lane is given up: it stands at a kink [1]."""
LARGEST = 1.0
"""Largest change of a logarithm in a step [1]: a factor of e."""


class ShortRuns(eqx.Module):
    """Runs on one even grid, stacked along a leading axis."""

    start: Float[Array, "... 3"] = eqx.field(converter=real, metadata=si("m"))
    """Lower carriage, upper carriage and height at rest [m]."""
    voltage: Float[Array, "... intervals 2"] = eqx.field(converter=real, metadata=si("V"))
    """Commands [V]."""
    knock: Float[Array, "... intervals"] = eqx.field(converter=real, metadata=si("N"))
    """Horizontal force on the end-effector [N]."""
    measured: Float[Array, "... rows 6"] = eqx.field(converter=real, metadata=si("rad, m"))
    r"""$[\\alpha_1, \\alpha_2, x_e, \\delta_e, q_3, q_4]$ at the ends of the intervals."""
    weight: Float[Array, "... rows 6"] = eqx.field(converter=real, metadata=si("1/rad, 1/m"))
    """Inverse standard deviations; 0 where nothing was measured."""


class Task(eqx.Module):
    """A run and what isn't fitted of its robot; of many runs, stacked."""

    robot: Robot
    interval: Float[Array | np.ndarray, "..."]
    run: ShortRuns
    rubbing_drives: bool = eqx.field(static=True)

    def residuals(self, point: Float[Array, "4"]) -> Float[Array, "rows 6"]:
        """Measured minus simulated over the noise, the encoders' zero taken out."""
        run = self.run
        force, inertia, damping, pretension = jnp.exp(point)
        fitted = replace(
            self.robot,
            {
                "friction_coefficient": force / (4 * pretension),
                "drive_inertia": inertia,
                "drive_damping": damping,
                "effective_pretension": pretension,
            },
        )
        states = simulate_linear(
            fitted,
            rest(fitted, *run.start),
            height=run.start[2],
            interval=self.interval,
            voltage=run.voltage,
            knock=run.knock,
            rubbing_drives=self.rubbing_drives,
        )
        x, tilt, lower, upper, height = states.position.T
        radius = value(self.robot, "effective_radius")
        along, across = lower - lower[0], height - height[0]
        angle = jnp.stack([along + across, along - across], axis=1) / radius
        frame = jnp.stack([x, tilt, lower, upper], axis=1)
        # The encoders' zero is arbitrary; the camera's isn't.
        turned = encoder_residuals(run.measured[:, :2] - angle, run.weight[:, :2])
        seen = run.weight[:, 2:] * (run.measured[:, 2:] - frame)
        return jnp.concatenate([turned, seen], axis=1)


class Batch(eqx.Module):
    """Runs, and what isn't fitted of the robot that made all of them."""

    robot: Robot
    interval: Float[np.ndarray, ""]
    runs: ShortRuns
    rubbing_drives: bool

    def rows(self, rows: Int[np.ndarray, " some"]) -> "Batch":
        """Some of the runs."""
        runs = jax.tree.map(lambda leaf: leaf[rows], self.runs)
        return Batch(self.robot, self.interval, runs, self.rubbing_drives)

    def each(
        self,
        function: Callable[[tuple["Task", Array]], Result],
        points: Float[np.ndarray, "runs 4"],
    ) -> Result:
        """A function of every run at a point.

        Args:
            function: The function.
            points: A point for each run.

        Returns:
            The results, stacked.
        """
        of_one = _Each(self.robot, self.interval, self.rubbing_drives, function)
        size = LANES if len(points) > LANES // 2 else FEW
        return in_chunks(of_one, (self.runs, points), size=size)


class _Each(eqx.Module):
    """A function of a run and a point. All runs share the robot, which is compiled once."""

    robot: Robot
    interval: Float[np.ndarray | Array, ""]
    rubbing_drives: bool = eqx.field(static=True)
    function: Callable[[tuple["Task", Array]], PyTree] = eqx.field(static=True)

    def __call__(self, lane: tuple[ShortRuns, Float[Array, "4"]]) -> PyTree:
        run, point = lane
        return self.function((Task(self.robot, self.interval, run, self.rubbing_drives), point))


class Normal(NamedTuple):
    """Misfit of a lane with its normal equations; of many, stacked."""

    cost: Float[Array | np.ndarray, "..."]
    gradient: Float[Array | np.ndarray, "... 4"]
    matrix: Float[Array | np.ndarray, "... 4 4"]


class Lanes(NamedTuple):
    """Where fits stand, and how many steps each of them took."""

    point: Float[np.ndarray, "runs 4"]
    cost: Float[np.ndarray, " runs"]
    gradient: Float[np.ndarray, "runs 4"]
    information: Float[np.ndarray, "runs 4 4"]
    promised: Float[np.ndarray, " runs"]
    steps: Int[np.ndarray, " runs"]


def _normal(lane: tuple[Task, Float[Array, "4"]]) -> Normal:
    """A run's misfit at a point, with its normal equations."""
    task, point = lane

    def both(x: Float[Array, "4"]) -> tuple[Array, Array]:
        residuals = task.residuals(x)
        return residuals, residuals

    jacobian, residuals = jax.jacfwd(both, has_aux=True)(point)
    jacobian = jacobian.reshape(-1, 4)
    matrix = jacobian.T @ jacobian
    cost = jnp.sum(jnp.square(residuals))
    # A derivative that isn't finite stands on the diagonal.
    good = jnp.isfinite(cost) & jnp.all(jnp.isfinite(matrix))
    return Normal(jnp.where(good, cost, jnp.inf), jacobian.T @ residuals.ravel(), matrix)


def followed(batch: Batch, points: Float[np.ndarray, "runs 4"], *, steps: int) -> Lanes:
    """Steps by Levenberg and Marquardt, of each lane until it promises nothing more.

    Lanes that have come to rest are left out of the next step, so that none waits for another.
    """
    count = len(points)
    at = batch.each(_normal, points)
    lanes = Lanes(points, *at, _promised(at), np.zeros(count, int))
    damping = np.full(count, DAMPING.first)
    for _ in range(steps):
        goes_on = np.isfinite(lanes.cost) & ~_promise_nothing(lanes) & (damping < MOST_DAMPED)
        rows = np.flatnonzero(goes_on)
        if not rows.size:
            break
        here = Normal(lanes.cost[rows], lanes.gradient[rows], lanes.information[rows])
        moved = np.clip(_steps(here, damping[rows] + REGULAR), -LARGEST, LARGEST)
        candidates = lanes.point[rows] + moved
        tried = batch.rows(rows).each(_normal, candidates)
        better = tried.cost < here.cost
        new = Lanes(candidates, *tried, _promised(tried), lanes.steps[rows])
        for whole, part in zip(*map(jax.tree.leaves, (lanes, new)), strict=True):
            whole[rows[better]] = part[better]
        lanes.steps[rows] += 1
        damping[rows] *= np.where(better, 1 / DAMPING.fall, DAMPING.rise)
    return lanes


def _steps(at: Normal, damping: Float[np.ndarray, " runs"]) -> Float[np.ndarray, "runs 4"]:
    """The damped step of each lane; none where nothing is finite."""
    good = np.isfinite(at.cost)
    matrix = np.where(good[:, None, None], at.matrix, 0.0)
    return damped_step(np.where(good[:, None], at.gradient, 0.0), matrix, damping)


def _promised(at: Normal) -> Float[np.ndarray, " runs"]:
    """What a step without damping would save of each misfit."""
    steps = _steps(at, np.full(len(at.cost), REGULAR))
    gradient = np.where(np.isfinite(at.cost)[:, None], at.gradient, 0.0)
    return -np.einsum("ij,ij->i", gradient, steps)


def is_minimum(lanes: Lanes, measured: Int[np.ndarray, " runs"]) -> Bool[np.ndarray, " runs"]:
    """Lanes that have come to rest where their noise is all that is left."""
    near = lanes.cost <= DIVERGED * np.maximum(measured, 1)
    return near & _promise_nothing(lanes)


def _promise_nothing(lanes: Lanes) -> Bool[np.ndarray, " runs"]:
    return lanes.promised <= np.maximum(CONVERGED, 1e-6 * lanes.cost)


def unfinished(lanes: Lanes, row: int, chi_square: float) -> str:
    """Why a finite fit isn't to be used.

    Args:
        lanes: The fits.
        row: Which of them.
        chi_square: Its mean squared residual [1].

    Returns:
        The reason; empty if it is.
    """
    if not _promise_nothing(lanes)[row]:
        return f"used up its steps: {lanes.promised[row]:.3g} more of its misfit is promised"
    if chi_square > DIVERGED:
        return f"came to rest {chi_square:.3g} times as far from the logs as their noise is"
    return ""
