"""Where a fit begins: the best valleys of a scan.

The vibration's phase wraps, so a fit that starts at the wrong pretension ends in a local
minimum. A scan over pretension and friction force on a coarse grid finds the valleys.
"""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.accumulate import run_residuals
from identification.misfit import channel_misfit
from identification.record import Record

LANES = 240
"""Simulations side by side; a fixed number, so that one compilation serves every scan."""

PRETENSIONS = tuple(float(t) for t in 15 * 1.06 ** np.arange(68))
"""Effective pretensions to try [N]: 6 % apart, as far as the phase of a few periods goes."""

FRICTION_FORCES = tuple(float(f) for f in 0.6 * 1.5 ** np.arange(9))
"""Friction forces of a carriage to try, 4Tμ [N]."""

KNOCKS = tuple(float(f) for s in (-1, 1) for f in s * 2.0 * 1.25 ** np.arange(20))
"""Forces of a knock to try [N]."""


@eqx.filter_jit
def costs(
    robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "lanes n"],
    run: Int[Array, " lanes"],
    records: Record,
) -> Float[Array, " lanes"]:
    """Misfit of many simulations, see `identification.misfit`.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: Free quantities and circumstances of each simulation.
        run: Which run each of them is of.
        records: The runs.

    Returns:
        The misfits; infinite where a simulation diverged.
    """

    def one(unknown: Float[Array, " n"], number: Int[Array, ""]) -> Float[Array, ""]:
        chosen = jax.tree.map(lambda leaf: leaf[number], records)
        found = run_residuals(robot, free, unknown, chosen)
        rows = jnp.full(2, jnp.sum(chosen.angle_weight > 0))
        frames = jnp.sum(chosen.frame_weight > 0, axis=0)
        duration = jnp.sum(chosen.inputs.duration)
        angle = channel_misfit(found.angle, rows, duration)
        frame = channel_misfit(found.frame, frames, duration)
        misfit = jnp.sum(angle.cost) + jnp.sum(frame.cost)
        return jnp.where(jnp.isfinite(misfit), misfit, jnp.inf)

    lanes = jax.tree.map(lambda leaf: leaf.reshape(-1, LANES, *leaf.shape[1:]), (unknowns, run))
    return jax.lax.map(lambda lane: jax.vmap(one)(*lane), lanes).reshape(-1)


def scan(
    robot, free: tuple[str, ...], unknowns: np.ndarray, run: Sequence[int], records: Record
) -> Float[np.ndarray, " lanes"]:
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
    count = len(run)
    padding = -count % LANES
    unknowns = np.concatenate([unknowns, np.repeat(unknowns[:1], padding, axis=0)])
    numbers = np.concatenate([np.asarray(run), np.repeat(run[0], padding)])
    found = costs(robot, free, jnp.asarray(unknowns), jnp.asarray(numbers), records)
    return np.asarray(found)[:count]
