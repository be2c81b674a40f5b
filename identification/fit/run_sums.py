"""What each run adds to the normal equations: residuals, forward-mode Jacobians, their sums.

A run's Jacobian has thousands of rows and some ten columns, one for each free quantity and for
each of the run's circumstances: forward mode makes it along the simulation, without keeping the
simulation, and only its sums are carried out. Reverse mode would keep every step of every
contact. Runs are simulated together by one compiled
function, see `identification.fit.lanes`.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.axis.motion import AxisParameters, axis_positions
from identification.data.circumstances import CLOCK, TURNING_DRIVES, Circumstances
from identification.data.record import MotorRecord, Record
from identification.fit.misfit import channel_misfit
from identification.fit.residuals import (
    Motion,
    Residuals,
    encoder_residuals,
    residuals,
    run_motion,
)
from identification.fit.unknowns.unknowns import Unknowns, apply
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.parameters import Robot

BLOCKS = 40
"""Stretches of time into which a run's score is summed, for standard errors."""


class RunSums(NamedTuple):
    """What one run adds to the normal equations, see `identification.fit.misfit`."""

    cost: Float[Array, " channels"]
    """Misfit of each channel; without the cable only the encoders have one."""
    weight: Float[Array, " channels"]
    """How much each channel counts, 1 while its residuals are noise."""
    information: Float[Array, "channels n n"]
    """Jacobian transposed times Jacobian of each channel, at its full weight."""
    gradient: Float[Array, " n"]
    """Jacobian transposed times residuals, with what is known before."""
    scores: Float[Array, "blocks n"]
    """The gradient's parts from `BLOCKS` stretches of time."""
    prior_cost: Float[Array, ""]
    """Misfit of what is known of the run's circumstances before."""
    prior_information: Float[Array, "n n"]
    """Information of that."""
    residuals: Residuals | Float[Array, "rows 2"]
    """The residuals themselves."""

    @property
    def total(self) -> float:
        """The misfit of everything."""
        return float(self.cost.sum() + self.prior_cost)

    @property
    def matrix(self) -> Float[Array | np.ndarray, "n n"]:
        """The Gauss-Newton matrix."""
        channels = (self.weight[:, None, None] * self.information).sum(axis=0)
        return channels + self.prior_information


jax.export.register_namedtuple_serialization(RunSums, serialized_name="RunSums")


def motor_angles(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: MotorRecord
) -> Float[Array, "rows 2"]:
    """Angles of the bare drives through a run.

    Args:
        robot: The robot with its fixed quantities; its drives' dry friction is exact here.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them; then the run's circumstances, where a
            run of the campaign begins in motion.
        record: The run.

    Returns:
        Angles from the start [rad].
    """
    drive = apply(robot, free, unknown[: len(free)]).drive
    torque = motor_torque(drive, record.voltage)
    speeds = jnp.zeros(2)
    if unknown.size > len(free):
        begun = Circumstances.of(unknown[len(free) :]).beginning
        speeds = jnp.stack([getattr(begun, name) for name in TURNING_DRIVES])

    def turn(
        torque: Float[Array, " intervals"],
        friction: Float[Array, ""],
        speed: Float[Array, ""],
    ) -> Float[Array, " rows"]:
        axis = AxisParameters(drive.inertia, drive.damping, friction, 0.0)
        start = jnp.zeros_like(torque[0])
        steps = record.duration
        return axis_positions(axis, torque, steps=steps, start=start, velocity=speed)

    every = jax.vmap(turn, in_axes=(1, 0, 0), out_axes=1)
    return every(torque, drive.frictions, speeds)


def run_residuals(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: Record
) -> Residuals:
    """Residuals of one run at a fit's unknowns.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        The residuals.
    """
    return residuals(*run_motion(robot, free, unknown, record), record)


def run_misfit(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: Record
) -> Float[Array, ""]:
    """Misfit of one run at a fit's unknowns, see `identification.fit.misfit`.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        The misfit of both sensors; infinite where the simulation diverged.
    """
    residual = run_residuals(robot, free, unknown, record)
    angle = channel_misfit(residual.angle, record.readings, record.length)
    frame = channel_misfit(residual.frame, record.frames, record.length)
    misfit = jnp.sum(angle.cost) + jnp.sum(frame.cost)
    return jnp.where(jnp.isfinite(misfit), misfit, jnp.inf)


def run_sums(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: Record
) -> RunSums:
    """Sums of one run with the cable on.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        The sums.
    """
    residual, jacobian = residuals_and_jacobian(robot, free, unknown, record)
    end = record.length
    of_angles = _stretch(_instants(record.inputs.duration), end)
    encoders = _channel_sums(residual.angle, jacobian.angle, record.readings, of_angles, end)
    of_frames = _stretch(record.frame_time, end)
    camera = _channel_sums(residual.frame, jacobian.frame, record.frames, of_frames, end)
    return _gathered((encoders, camera), residual, residual.prior, jacobian.prior)


def residuals_and_jacobian(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: Record
) -> tuple[Residuals, Residuals]:
    """Residuals of one run, and their derivatives.

    The camera's clock moves no robot: its derivatives need no tangent of the motion.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        The residuals, and the same with a last axis for their derivatives.
    """
    count = len(free)
    first, last = count + CLOCK.start, count + CLOCK.stop
    moving, clock = jnp.delete(unknown, slice(first, last)), unknown[first:last]

    def joined(moving: Float[Array, "... _"], clock: Float[Array, "... _"]) -> Array:
        parts = [moving[..., :first], clock, moving[..., first:]]
        return jnp.concatenate(parts, axis=-1)

    def of_moving(x: Float[Array, " moving"]) -> tuple[Residuals, tuple[Residuals, Motion]]:
        motion, circumstances = run_motion(robot, free, joined(x, clock), record)
        residual = residuals(motion, circumstances, record)
        return residual, (residual, motion)

    by_moving, (residual, motion) = jax.jacfwd(of_moving, has_aux=True)(moving)

    def of_clock(x: Float[Array, " clock"]) -> Residuals:
        circumstances = Circumstances.of(joined(moving, x)[count:])
        return residuals(motion, circumstances, record)

    by_clock = jax.jacfwd(of_clock)(clock)
    return residual, jax.tree.map(joined, by_moving, by_clock)


def motor_sums(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " n"], record: MotorRecord
) -> RunSums:
    """Sums of one step of the bare drives.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them.
        record: The run.

    Returns:
        The sums.
    """

    def both(x: Float[Array, " n"]) -> tuple[Float[Array, "rows 2"], Float[Array, "rows 2"]]:
        difference = record.angle - motor_angles(robot, free, x, record)
        residual = encoder_residuals(difference, record.weight)
        return residual, residual

    jacobian, residual = jax.jacfwd(both, has_aux=True)(unknown)
    count, end = jnp.sum(record.share, axis=0), jnp.sum(record.duration)
    of_angles = _stretch(_instants(record.duration), end)
    encoders = _channel_sums(residual, jacobian, count, of_angles, end)
    nothing = jnp.zeros((0, unknown.size))
    return _gathered((encoders,), residual, nothing[:, 0], nothing)


def _instants(duration: Float[Array, " intervals"]) -> Float[Array, " rows"]:
    """Ends of intervals, the begin first [s]."""
    return jnp.concatenate([jnp.zeros(1), jnp.cumsum(duration)])


def _stretch(time: Float[Array, " n"], end: Float[Array, ""]) -> Int[Array, " n"]:
    """Which of a run's `BLOCKS` an instant is in."""
    return jnp.clip(time / end * BLOCKS, 0.0, BLOCKS - 1.0).astype(int)


class _ChannelSums(NamedTuple):
    """Sums over the channels of one stream, as in `RunSums`."""

    cost: Float[Array, " channels"]
    weight: Float[Array, " channels"]
    information: Float[Array, "channels n n"]
    scores: Float[Array, "blocks n"]


def _channel_sums(
    residual: Float[Array, "samples channels"],
    jacobian: Float[Array, "samples channels n"],
    count: Float[Array, " channels"] | Int[Array, " channels"],
    block: Int[Array, " samples"],
    duration: Float[Array, ""],
) -> _ChannelSums:
    misfit = channel_misfit(residual, count, duration)
    pull = jnp.sum((misfit.weight[None] * residual)[..., None] * jacobian, axis=1)
    return _ChannelSums(
        cost=misfit.cost,
        weight=misfit.weight,
        information=jnp.einsum("scn,scm->cnm", jacobian, jacobian),
        scores=jax.ops.segment_sum(pull, block, num_segments=BLOCKS),
    )


def _gathered(
    streams: Sequence[_ChannelSums],
    residual: Residuals | Float[Array, "rows 2"],
    prior: Float[Array, " circumstances"],
    slope: Float[Array, "circumstances n"],
) -> RunSums:
    """A run's sums from those of its streams and what is known before, with its Jacobian."""
    scores, pull = sum(stream.scores for stream in streams), prior @ slope
    return RunSums(
        *(jnp.concatenate(parts) for parts in list(zip(*streams, strict=True))[:3]),
        gradient=jnp.sum(scores, axis=0) + pull,
        scores=scores.at[0].add(pull),
        prior_cost=jnp.sum(jnp.square(prior)),
        prior_information=slope.T @ slope,
        residuals=residual,
    )


def assemble(
    unknowns: Unknowns, sums: Mapping[int, RunSums], *, shared: bool
) -> tuple[Normal, Float[np.ndarray, "runs blocks size"]]:
    """The normal equations of several runs in the fit's vector.

    Args:
        unknowns: The layout.
        sums: Sums of each run by its number in the layout, with or without the
            circumstances' columns, as NumPy arrays.
        shared: Whether the runs may say anything about the shared quantities, or about
            their own circumstances alone.

    Returns:
        Normal equations and scores over all unknowns.
    """
    size = unknowns.size
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    scores = np.zeros((len(sums), BLOCKS, size))
    for row, (run, of_run) in enumerate(sums.items()):
        quantities = unknowns.opened[unknowns.local[run]] & shared
        is_open = np.concatenate([quantities, unknowns.active[run]])
        columns = np.flatnonzero(is_open[: of_run.gradient.size])
        at = unknowns.of_run(run)[columns]
        # Quantities that share an unknown add up in it.
        # What overflows is found where the fit is judged, with the run's name.
        with np.errstate(over="ignore", invalid="ignore"):
            np.add.at(matrix, np.ix_(at, at), of_run.matrix[np.ix_(columns, columns)])
        np.add.at(gradient, at, of_run.gradient[columns])
        for column, place in zip(columns, at, strict=True):
            scores[row][:, place] += of_run.scores[:, column]
    cost = sum((of_run.total for of_run in sums.values()), 0.0)
    return Normal(cost, gradient, matrix), scores
