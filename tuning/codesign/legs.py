r"""Legs of many robots under one command law, and what is wrong with each.

What a robot is told doesn't depend on how it was designed: a PD and the share of the way at
every sample. Derivatives by whatever they are designed from are one forward pass.
"""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.sensors import Encoder
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.numerics.side_by_side import side_by_side
from scdpr_jax.robot.fields import si
from tuning.codesign.models import Models, resting
from tuning.gains.objectives import tracking_error

COUNTS = 26624.0
"""Counts of the rigs' encoders for a turn of a driver pulley [1]."""
HOLD = 1.0
"""Time after the move that is looked at [s]: some three periods of 3 Hz."""
LANES = 96
"""Legs that are simulated side by side."""
SLOPED_LANES = 24
"""Legs whose derivatives are computed side by side."""
VOLTAGE_SHARE = 0.93
"""Share of the voltage limit that commands are to stay within [1]: at 1 kHz a count of the
encoders moves the derivative twice as much as on the search's coarser grid."""

_VIBRATION = 1e-3
"""Vibration, peak to peak, that counts as one [m]."""
_RESTING = 3e-3
"""Distance of where it rests from the target that counts as one [m]."""
_TRACKING = 30e-3
"""Largest error, Eq. (26), that counts as one [m]; the paper reports 50 mm."""
_EFFORT = 4.0
"""Share of the voltage limit, root mean square, that counts as one [1]: it decides between
designs that are alike otherwise."""
_EXCESS = 0.01
"""Excess of a command over `VOLTAGE_SHARE` that counts as one, over the limit [1]."""
_LOOKED_AT = 8e-3
"""Time between the samples that count [s]: a sixteenth of the fastest period, 8 Hz."""
_PEAK_TO_PEAK = 2 * np.sqrt(2)
"""Of a sinusoid over its root mean square [1]."""


class Grid(NamedTuple):
    """Samples of a leg."""

    moving: int
    """Intervals until the move ends."""
    holding: int
    """Intervals after it."""
    period: float
    """Sample period [s]."""
    counts: float = COUNTS
    """Counts of the encoders for a turn of a driver pulley [1]."""

    @property
    def time(self) -> Float[np.ndarray, " samples"]:
        """Times before the move's end, positive after it [s]."""
        return self.period * np.arange(-self.moving, self.holding + 1)


def grid(move_time: float, period: float) -> Grid:
    """The samples of a move.

    Args:
        move_time: The longest that the move may take [s].
        period: Sample period [s].

    Returns:
        The grid; shorter moves end at the same sample.
    """
    return Grid(round(move_time / period) + 1, round(HOLD / period), period)


class Command(eqx.Module):
    """What the controller of both drives is told."""

    controller: PD
    """The PD controller of both drives, at the grid's period."""
    share: Float[Array, "... samples"] = eqx.field(metadata=si("1"))
    """Share of the way at every sample of the grid [1]."""


class Found(eqx.Module):
    """What a leg comes to; the first axis is the leg."""

    residuals: Float[Array | np.ndarray, "... residuals"] = eqx.field(metadata=si("1"))
    """What is wrong with it: their squares sum to its cost [1]."""
    vibration: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Peak to peak of $x_e$ after the move [m]."""
    resting_error: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Distance of the mean of $x_e$ after the move from the target [m]."""
    largest_error: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Largest error against the commanded reference, Eq. (26) [m]."""
    largest_voltage: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("V"))
    """Largest command [V]."""

    @property
    def cost(self) -> Float[Array | np.ndarray, "..."]:
        """Sum of the squared residuals [1]."""
        return (self.residuals**2).sum(axis=-1)


def run(models: Models, command: Command, on: Grid) -> Found:
    """Legs of any number of models.

    Args:
        models: The models.
        command: What the controller is told.
        on: The grid.

    Returns:
        What each comes to.
    """
    return side_by_side(
        lambda own: _chunk(own, command, on), models, size=LANES, program=(_chunk, on)
    )


def linearise(
    models: Models, command: Command, directions: Command, on: Grid
) -> tuple[Float[np.ndarray, "n residuals"], Float[np.ndarray, "n residuals directions"]]:
    """Residuals of any number of models and how they change.

    Args:
        models: The models.
        command: What the controller is told.
        directions: How that may change, stacked.
        on: The grid.

    Returns:
        Residuals and their derivatives along the directions.
    """
    return side_by_side(
        lambda own: _sloped(own, command, directions, on),
        models,
        size=SLOPED_LANES,
        program=(_sloped, on, directions.share.shape[0]),
    )


@functools.partial(jax.jit, static_argnames="on")
def _chunk(models: Models, command: Command, on: Grid) -> Found:
    return jax.vmap(lambda model: _leg(model, command, on))(models)


@functools.partial(jax.jit, static_argnames="on")
def _sloped(
    models: Models, command: Command, directions: Command, on: Grid
) -> tuple[Float[Array, "n residuals"], Float[Array, "n residuals directions"]]:
    def residuals(command: Command) -> Float[Array, "n residuals"]:
        return _chunk(models, command, on).residuals

    return jax.vmap(
        lambda direction: jax.jvp(residuals, (command,), (direction,)), out_axes=(None, -1)
    )(directions)


def _leg(model: Models, command: Command, on: Grid) -> Found:
    way = model.end - model.start
    commanded = model.start[None] + command.share[:, None] * way[None]
    done = closed_loop(
        model.robot,
        resting(model),
        command.controller,
        reference=commanded,
        encoder=Encoder(on.counts),
    )
    place = done.states.position[:, jnp.asarray((0, 4))]
    limit = model.robot.drive.voltage_limit
    error = jnp.max(tracking_error(place, commanded))
    held = place[on.moving :, 0]
    size = jnp.max(jnp.abs(done.voltage), axis=1) / limit
    return Found(
        residuals=_residuals(held, model.end[0], error, size, on),
        vibration=jnp.max(held) - jnp.min(held),
        resting_error=jnp.abs(jnp.mean(held) - model.end[0]),
        largest_error=error,
        largest_voltage=limit * jnp.max(size),
    )


def _residuals(
    held: Float[Array, " held"],
    target: Float[Array, ""],
    error: Float[Array, ""],
    size: Float[Array, " intervals"],
    on: Grid,
) -> Float[Array, " residuals"]:
    every = round(_LOOKED_AT / on.period)
    seen = held[::every]
    mean = jnp.mean(seen)
    windows = size[: size.size // every * every].reshape(-1, every)
    excess = jnp.maximum(jnp.max(windows, axis=1) - VOLTAGE_SHARE, 0.0)
    effort = jnp.sqrt(jnp.mean(jnp.square(size)))
    return jnp.concatenate(
        [
            _PEAK_TO_PEAK / _VIBRATION / np.sqrt(seen.size) * (seen - mean),
            (mean - target)[None] / _RESTING,
            error[None] / _TRACKING,
            effort[None] / _EFFORT,
            excess / _EXCESS,
        ]
    )
