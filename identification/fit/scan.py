"""Misfits of many simulations side by side: the scans that a fit's starts come from."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.data.record import Record
from identification.fit.lanes import in_lanes
from identification.fit.misfit import channel_misfit
from identification.fit.run_sums import run_residuals
from scdpr_jax.robot.parameters import Robot

LANES = 120
"""Simulations of a chunk; a fixed number, so that one compilation serves every scan."""


@eqx.filter_jit
def costs(
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "lanes n"],
    run: Int[Array, " lanes"],
    records: Record,
) -> Float[Array, " lanes"]:
    """Misfit of many simulations, see `identification.fit.misfit`.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: Free quantities and circumstances of each simulation.
        run: Which run each of them is of.
        records: The runs.

    Returns:
        The misfits; infinite where a simulation diverged.
    """

    def cost(unknown: Float[Array, " n"], number: Int[Array, ""]) -> Float[Array, ""]:
        record = jax.tree.map(lambda leaf: leaf[number], records)
        residual = run_residuals(robot, free, unknown, record)
        rows = jnp.sum(record.angle_share, axis=0)
        frames = jnp.sum(record.frame_weight > 0, axis=0)
        duration = jnp.sum(record.inputs.duration)
        angle = channel_misfit(residual.angle, rows, duration)
        frame = channel_misfit(residual.frame, frames, duration)
        misfit = jnp.sum(angle.cost) + jnp.sum(frame.cost)
        return jnp.where(jnp.isfinite(misfit), misfit, jnp.inf)

    return jax.vmap(cost)(unknowns, run)


def scan(
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[np.ndarray, "count n"],
    run: Sequence[int],
    records: Record,
) -> Float[np.ndarray, " count"]:
    """Misfits of any number of simulations, padded to whole chunks.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: Free quantities and circumstances of each simulation.
        run: Which run each of them is of.
        records: The runs.

    Returns:
        The misfits.
    """
    return in_lanes(costs, robot, free, unknowns, run, records, size=LANES)
