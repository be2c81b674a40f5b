r"""Four-parameter fits of very many short runs in one batch, on the linear engine.

Friction force $4T\mu$, drive inertia and damping, and effective pretension, of one run near
one height each. All runs of a batch have one grid; every run is a lane of its own, and a lane
that fails is a row with its reason, never a lost batch.

A start is put right in three stages: the momentum of the whole robot tells the drives and
the friction force, whatever the loop does inside of it; a scan over the pretension then finds
the valley of the vibration's phase; and all channels together end in it. Lanes that aren't
there yet go on among themselves.
"""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.fit.residuals import encoder_residuals
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.numerics.batches import in_chunks
from scdpr_jax.numerics.levenberg_marquardt import Damping, damped_step
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import rest

NAMES = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
"""What is fitted, in the order of the results."""

LANES = 64
"""Fits side by side."""

PRETENSIONS = tuple(float(factor) for factor in np.geomspace(0.36, 2.8, 36))
"""Multiples of the start's pretension that are scanned [1]: 6 % apart."""

CONVERGED = 1e-3
"""Decrease of the sum of squares that a step still promises, below which a lane is done [1]."""

DIVERGED = 2.0
"""Mean squared residual over which a lane that came to rest isn't at its minimum [1]."""


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


@dataclasses.dataclass(frozen=True, eq=False)
class ManyEstimates:
    """Fits of many runs, one a row."""

    values: Float[np.ndarray, "runs 4"]
    """Fitted values in the order of `NAMES` [1, kg m², N m s, N]."""
    sigma: Float[np.ndarray, "runs 4"]
    """Standard errors by the noise alone."""
    chi_square: Float[np.ndarray, " runs"]
    """Mean squared residual [1]."""
    iterations: np.ndarray
    """Steps of the last stage."""
    failure: tuple[str, ...]
    """Why a row isn't to be used; empty where it is."""

    @property
    def converged(self) -> np.ndarray:
        """Which rows may be used."""
        return np.array([not reason for reason in self.failure])


class _Task(eqx.Module):
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


class _Normal(NamedTuple):
    """Misfit of a lane with its normal equations."""

    cost: Float[Array, ""]
    gradient: Float[Array, "4"]
    matrix: Float[Array, "4 4"]


class _Lane(eqx.Module):
    """Where a fit stands; of many, stacked."""

    point: Float[Array | np.ndarray, "... 4"]
    cost: Float[Array | np.ndarray, "..."]
    promised: Float[Array | np.ndarray, "..."]
    information: Float[Array | np.ndarray, "... 4 4"]


def estimate_many(
    robot: Robot,
    runs: ShortRuns,
    starts: Float[np.ndarray, "runs 4"],
    *,
    interval: float,
    rounds: int = 6,
) -> ManyEstimates:
    """Fit every run by itself, all of them in one batch.

    Args:
        robot: What isn't fitted; its drives' dry friction is held.
        runs: The runs, of a rank more than one of them.
        starts: Where each search begins, in the order of `NAMES`; twice too large or too
            small is near enough.
        interval: Length of the grid's intervals [s].
        rounds: Most rounds of `STEPS` steps of the last stage.

    Returns:
        The fits.

    Raises:
        ValueError: If a start isn't positive.
    """
    starts = np.asarray(starts, dtype=float)
    if not np.all(starts > 0):
        raise ValueError(
            f"`starts` must be positive, got {float(starts.min())} at the least: the fit holds "
            f"the logarithms of {', '.join(NAMES)}."
        )
    count = len(starts)
    alike = jax.tree.map(lambda leaf: np.broadcast_to(leaf, (count, *leaf.shape)), robot)
    rubbing = bool(np.any(robot.drive.frictions != 0))
    task = _Task(alike, np.full(count, interval), runs, rubbing)

    balanced = in_chunks(_balanced, (task, _encoded(starts)), size=LANES)
    points = in_chunks(_scanned, (task, balanced), size=LANES)
    lanes, steps = _followed_together(task, points, rounds=rounds)
    return _judged(lanes, np.sum(np.asarray(runs.weight) > 0, axis=(1, 2)), steps)


def _followed_together(
    task: _Task, points: Float[np.ndarray, "runs 4"], *, rounds: int
) -> tuple[_Lane, Int[np.ndarray, " runs"]]:
    """Lanes that are followed until they promise nothing, and the steps that each took."""
    lanes = in_chunks(_followed, (task, points), size=LANES)
    steps = np.full(len(points), STEPS)
    for _ in range(rounds - 1):
        rows = np.flatnonzero(np.isfinite(lanes.cost) & (lanes.promised > CONVERGED))
        if not rows.size:
            break
        unfinished = jax.tree.map(
            lambda leaf, rows=rows: np.asarray(leaf)[rows], (task, lanes.point)
        )
        further = in_chunks(_followed, unfinished, size=LANES)
        for whole, part in zip(*map(jax.tree.leaves, (lanes, further)), strict=True):
            whole[rows] = part
        steps[rows] += STEPS
    return lanes, steps


STEPS = 4
"""Steps of the last stage in a round."""


def _encoded(values: Float[np.ndarray, "runs 4"]) -> Float[np.ndarray, "runs 4"]:
    """Logarithms of friction force, inertia, damping and pretension."""
    force = 4 * values[:, 3] * values[:, 0]
    return np.log(np.stack([force, values[:, 1], values[:, 2], values[:, 3]], axis=1))


STANDING = 4.0
"""Travel of the lower carriage in an interval over its encoders' noise, up to which it may
stand [1]."""


LARGEST_SHARE = 5.0
"""Most that the momentum may change a start by, either way [1]: where friction is a small part
of it, the rest of it is taken from the start."""


def _balanced(lane: tuple[_Task, Float[Array, "4"]]) -> Float[Array, "4"]:
    r"""The start with friction force, inertia and damping by the whole robot's momentum.

    The loop's forces are internal, so that from rest, twice integrated,

    $$ m_e \Delta x_e + m_3 \Delta q_3 + m_4 \Delta q_4
       - \iint \big((\tau_1 + \tau_2)/r + F_k\big)
       = -\tfrac{2J}{r^2} \Delta q_3 - \tfrac{2b}{r^2} \int \Delta q_3
         - F \iint (\mathrm{sgn}\,\dot q_3 + \mathrm{sgn}\,\dot q_4) $$

    linear in J, b and F; the drives' dry friction is taken off their torques. The upper
    carriage is taken to slide as the lower one does, up to where that one stands again: the
    friction that holds it isn't known.
    """
    task, start = lane
    robot, run = task.robot, task.run
    radius = value(robot, "effective_radius")
    weight, measured = run.weight, run.measured - run.measured[:1]
    lower = radius / 2 * (measured[:, 0] + measured[:, 1])
    noise = radius / jnp.sqrt(jnp.sum(jnp.square(weight[0, :2])))
    travel = jnp.diff(lower)
    slides = jnp.abs(travel) > STANDING * noise
    turns = jnp.diff(measured[:, :2], axis=0)
    turning = jnp.abs(turns) * weight[:1, :2] > STANDING
    begun = jnp.cumsum(slides) > 0
    stood = jnp.cumsum(begun & ~slides) > 0

    def integral(rate: Float[Array, " intervals"]) -> Float[Array, " rows"]:
        return task.interval * jnp.concatenate([jnp.zeros_like(rate[:1]), jnp.cumsum(rate)])

    def twice(rate: Float[Array, " intervals"]) -> Float[Array, " rows"]:
        speed = integral(rate)
        return integral((speed[1:] + speed[:-1]) / 2)

    rubbed = robot.drive.frictions[None, :] * jnp.where(turning, jnp.sign(turns), 0.0)
    torque = jnp.sum(motor_torque(robot.drive, run.voltage) - rubbed, axis=1)
    masses = (
        value(robot, f"{name}_mass")
        for name in ("end_effector", "lower_carriage", "upper_carriage")
    )
    moved = (measured[:, 2], lower, measured[:, 5])
    momentum = sum(m * by for m, by in zip(masses, moved, strict=True))
    right = momentum - twice(torque / radius + run.knock)
    columns = jnp.stack(
        [
            -2 * twice(jnp.where(slides, jnp.sign(travel), 0.0)),
            -2 / jnp.square(radius) * lower,
            -2 / jnp.square(radius) * integral((lower[1:] + lower[:-1]) / 2),
        ],
        axis=1,
    )
    used = (weight[:, 2] > 0) & (weight[:, 5] > 0) & ~jnp.concatenate([stood[:1], stood])
    scale = jnp.exp(start[:3])
    system = jnp.where(used[:, None], columns * scale[None, :], 0.0)
    normal = system.T @ system
    # Where too little is seen, a billionth leads to the start itself.
    regular = 1e-9 * jnp.trace(normal) + jnp.finfo(normal.dtype).tiny
    rest = system.T @ (jnp.where(used, right, 0.0) - system @ jnp.ones_like(scale))
    share = 1 + jnp.linalg.solve(normal + regular * jnp.eye(3, dtype=normal.dtype), rest)
    return start.at[:3].add(jnp.log(jnp.clip(share, 1 / LARGEST_SHARE, LARGEST_SHARE)))


def _scanned(lane: tuple[_Task, Float[Array, "4"]]) -> Float[Array, "4"]:
    """The point with the pretension about it that fits best."""
    task, start = lane

    def misfit(factor: Float[Array, ""]) -> Float[Array, ""]:
        cost = jnp.sum(jnp.square(task.residuals(start.at[3].add(jnp.log(factor)))))
        return jnp.where(jnp.isfinite(cost), cost, jnp.inf)

    factors = jnp.asarray(PRETENSIONS, dtype=start.dtype)
    # One after the other: the lanes fill the processor as it is.
    best = factors[jnp.argmin(jax.lax.map(misfit, factors))]
    return start.at[3].add(jnp.log(best))


def _followed(lane: tuple[_Task, Float[Array, "4"]]) -> _Lane:
    """`STEPS` steps by Levenberg and Marquardt."""
    task, start = lane

    def normal(point: Float[Array, "4"]) -> _Normal:
        def both(x: Float[Array, "4"]) -> tuple[Array, Array]:
            residuals = task.residuals(x)
            return residuals, residuals

        jacobian, residuals = jax.jacfwd(both, has_aux=True)(point)
        jacobian = jacobian.reshape(-1, 4)
        matrix = jacobian.T @ jacobian
        cost = jnp.sum(jnp.square(residuals))
        # A derivative that isn't finite stands on the diagonal.
        good = jnp.isfinite(cost) & jnp.all(jnp.isfinite(matrix))
        return _Normal(jnp.where(good, cost, jnp.inf), jacobian.T @ residuals.ravel(), matrix)

    def step(best: tuple, _: None) -> tuple[tuple, None]:
        point, damping, at = best
        moved = damped_step(at.gradient, at.matrix, damping + REGULAR)
        candidate = point + jnp.clip(moved, -LARGEST, LARGEST)
        tried = normal(candidate)
        better = tried.cost < at.cost
        point, at = jax.tree.map(
            lambda new, old: jnp.where(better, new, old), (candidate, tried), (point, at)
        )
        damping = jnp.where(better, damping / DAMPING.fall, damping * DAMPING.rise)
        return (point, damping, at), None

    # Of the start, so that it belongs to the start's device as the rest of the lane does.
    nothing = 0 * start
    # The first step goes nowhere and finds out where it stands.
    unknown = _Normal(nothing[0] + jnp.inf, nothing, jnp.outer(nothing, nothing))
    begun = (start, nothing[0] + DAMPING.first, unknown)
    (point, _, at), _ = jax.lax.scan(step, begun, length=STEPS + 1)
    promised = -at.gradient @ damped_step(at.gradient, at.matrix, REGULAR)
    return _Lane(point, at.cost, promised, at.matrix)


DAMPING = Damping(first=1e-2, least=0.0)
"""Damping of the last stage."""
REGULAR = 1e-9
"""Damping that keeps what can't be told apart from breaking the solution [1]."""
LARGEST = 1.0
"""Largest change of a logarithm in a step [1]: a factor of e."""


def _judged(lanes: _Lane, count: np.ndarray, steps: np.ndarray) -> ManyEstimates:
    """The rows, with the reasons of those that failed."""
    force, inertia, damping, pretension = np.exp(lanes.point).T
    values = np.stack([force / (4 * pretension), inertia, damping, pretension], axis=1)
    chi_square = lanes.cost / np.maximum(count, 1)
    # The friction coefficient is the force over the pretension.
    turn = np.eye(4)
    turn[0, 3] = -1.0
    sigma = np.full(values.shape, np.inf)
    failure = []
    for row, matrix in enumerate(lanes.information):
        sizes = zip(NAMES, np.diag(matrix), strict=True)
        untold = [name for name, size in sizes if not size > 0]
        if not np.isfinite(lanes.cost[row]):
            failure.append("the simulation isn't finite at any point that was tried")
        elif untold:
            failure.append(f"nothing that was measured depends on {', '.join(untold)}")
        else:
            spread = turn @ np.linalg.pinv(matrix, hermitian=True) @ turn.T
            sigma[row] = values[row] * np.sqrt(np.diag(spread))
            failure.append(_unfinished(lanes, row, chi_square[row]))
    return ManyEstimates(values, sigma, chi_square, steps, tuple(failure))


def _unfinished(lanes: _Lane, row: int, chi_square: float) -> str:
    """Why a finite fit isn't to be used; nothing if it is."""
    if lanes.promised[row] > max(CONVERGED, 1e-6 * lanes.cost[row]):
        return f"used up its steps: {lanes.promised[row]:.3g} more of its misfit is promised"
    if chi_square > DIVERGED:
        return f"came to rest {chi_square:.3g} times as far from the logs as their noise is"
    return ""
