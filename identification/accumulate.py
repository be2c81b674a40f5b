"""Normal equations of a campaign: residuals, forward-mode Jacobians and their sums.

A campaign's runs are simulated together by one compiled function; the Jacobian has a
column for each free quantity and for each of the run's own circumstances.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.axis_motion import AxisParameters, axis_positions
from identification.levenberg_marquardt import Normal
from identification.misfit import channel_misfit
from identification.record import MotorRecord, Record
from identification.residuals import (
    Circumstances,
    Residuals,
    encoder_residuals,
    residuals,
)
from identification.unknowns import Unknowns, apply
from scdpr_jax.drive import motor_torque
from scdpr_jax.parameters import Drive, Robot

BLOCKS = 40
"""Stretches of time into which a run's score is summed, for standard errors."""


class RunSums(NamedTuple):
    """What one run adds to the normal equations, see `identification.misfit`."""

    cost: Float[Array, ""]
    """The misfit."""
    gradient: Float[Array, " n"]
    """Jacobian transposed times residuals."""
    matrix: Float[Array, "n n"]
    """Jacobian transposed times Jacobian."""
    scores: Float[Array, "blocks n"]
    """The gradient's parts from `BLOCKS` stretches of time."""


def motor_angles(drive: Drive, record: MotorRecord) -> Float[Array, "rows 2"]:
    """Angles of the bare drives through a run.

    Args:
        drive: The drive; its dry friction is exact here.
        record: The run.

    Returns:
        Angles from the start [rad].
    """
    axis = AxisParameters(drive.inertia, drive.damping, drive.friction, 0.0)
    torque = motor_torque(drive, record.voltage)

    def turn(torque: Float[Array, " intervals"]) -> Float[Array, " rows"]:
        start = jnp.zeros_like(torque[0])
        return axis_positions(axis, torque, steps=record.duration, start=start)

    return jax.vmap(turn, in_axes=1, out_axes=1)(torque)


def motor_residuals(drive: Drive, record: MotorRecord) -> Float[Array, "rows 2"]:
    """Measured minus simulated angles of the bare drives, over the noise.

    Args:
        drive: The drive.
        record: The run.

    Returns:
        Residuals; the encoders' arbitrary zero is taken out [1].
    """
    return encoder_residuals(record.angle - motor_angles(drive, record), record.weight)


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
    fitted = apply(robot, free, unknown[: len(free)])
    return residuals(fitted, Circumstances(*unknown[len(free) :]), record)


@eqx.filter_jit
def run_sums(
    robot: Robot, free: tuple[str, ...], unknowns: Float[Array, "runs n"], records: Record
) -> RunSums:
    """Sums of all runs with the cable on.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: For each run its free quantities and its circumstances.
        records: The runs.

    Returns:
        Each run's sums.
    """

    def one(unknown: Float[Array, " n"], record: Record) -> RunSums:
        def both(x: Float[Array, " n"]) -> tuple[Residuals, Residuals]:
            found = run_residuals(robot, free, x, record)
            return found, found

        jacobian, found = jax.jacfwd(both, has_aux=True)(unknown)
        end = jnp.sum(record.inputs.duration)
        when = jnp.concatenate([jnp.zeros(1), jnp.cumsum(record.inputs.duration)])

        def stretch(time: Float[Array, " n"]) -> Int[Array, " n"]:
            return jnp.clip(time / end * BLOCKS, 0.0, BLOCKS - 1.0).astype(int)

        sums = _known_sums(found.known, jacobian.known)
        rows = jnp.full(2, jnp.sum(record.angle_weight > 0))
        frames = jnp.sum(record.frame_weight > 0, axis=0)
        encoders = _channel_sums(found.angle, jacobian.angle, rows, stretch(when), end)
        camera = _channel_sums(
            found.frame, jacobian.frame, frames, stretch(record.frame_time), end
        )
        return jax.tree.map(lambda *parts: sum(parts), sums, encoders, camera)

    return jax.vmap(one)(unknowns, records)


@eqx.filter_jit
def motor_sums(
    robot: Robot, free: tuple[str, ...], unknowns: Float[Array, "runs n"], records: MotorRecord
) -> RunSums:
    """Sums of all steps of the bare drives.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: For each run its free quantities.
        records: The runs.

    Returns:
        Each run's sums.
    """

    def one(unknown: Float[Array, " n"], record: MotorRecord) -> RunSums:
        def both(
            x: Float[Array, " n"],
        ) -> tuple[Float[Array, "rows 2"], Float[Array, "rows 2"]]:
            found = motor_residuals(apply(robot, free, x).drive, record)
            return found, found

        jacobian, found = jax.jacfwd(both, has_aux=True)(unknown)
        rows = jnp.arange(found.shape[0])
        count = jnp.full(2, jnp.sum(record.weight > 0))
        block = rows * BLOCKS // found.shape[0]
        return _channel_sums(found, jacobian, count, block, jnp.sum(record.duration))

    return jax.vmap(one)(unknowns, records)


def _channel_sums(
    residual: Float[Array, "samples channels"],
    jacobian: Float[Array, "samples channels n"],
    count: Float[Array, " channels"] | Int[Array, " channels"],
    block: Int[Array, " samples"],
    duration: Float[Array, ""],
) -> RunSums:
    """Sums over the channels of one stream."""
    misfit = channel_misfit(residual, count, duration)
    pull = jnp.sum((misfit.weight[None] * residual)[..., None] * jacobian, axis=1)
    scores = jax.ops.segment_sum(pull, block, num_segments=BLOCKS)
    scaled = (jnp.sqrt(misfit.weight)[None, :, None] * jacobian).reshape(-1, jacobian.shape[-1])
    return RunSums(
        cost=jnp.sum(misfit.cost),
        gradient=jnp.sum(scores, axis=0),
        matrix=scaled.T @ scaled,
        scores=scores,
    )


def _known_sums(residual: Float[Array, "4"], jacobian: Float[Array, "4 n"]) -> RunSums:
    """Sums of what is known before, at its full weight."""
    gradient = residual @ jacobian
    scores = jnp.zeros((BLOCKS, jacobian.shape[-1])).at[0].set(gradient)
    return RunSums(jnp.sum(jnp.square(residual)), gradient, jacobian.T @ jacobian, scores)


def assemble(
    unknowns: Unknowns, runs: Sequence[int], sums: RunSums, *, shared: bool
) -> tuple[Normal, Float[np.ndarray, "runs blocks size"]]:
    """The normal equations of several runs in the fit's vector.

    Args:
        unknowns: The layout.
        runs: Number of the run in the layout that each row of the sums is of; -1 for a
            run to leave out.
        sums: Sums of the runs, with or without the circumstances' columns.
        shared: Whether the runs may say anything about the shared quantities, or about
            their own circumstances alone.

    Returns:
        Normal equations and scores over all unknowns.
    """
    size, names = unknowns.size, len(unknowns.free)
    matrix, gradient, cost = np.zeros((size, size)), np.zeros(size), 0.0
    scores = []
    sums = jax.tree.map(np.asarray, sums)
    for row, run in enumerate(runs):
        if run < 0:
            continue
        open_to_it = np.concatenate([np.full(names, shared), unknowns.active[run]])
        columns = np.flatnonzero(open_to_it[: sums.gradient.shape[1]])
        at = unknowns.of_run(run)[columns]
        matrix[np.ix_(at, at)] += sums.matrix[row][np.ix_(columns, columns)]
        gradient[at] += sums.gradient[row][columns]
        cost += float(sums.cost[row])
        score = np.zeros((BLOCKS, size))
        score[:, at] = sums.scores[row][:, columns]
        scores.append(score)
    return Normal(cost, gradient, matrix), np.array(scores).reshape(-1, BLOCKS, size)
