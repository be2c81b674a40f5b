r"""Legs of many robots under one command law, and what is wrong with each.

What a robot is told doesn't depend on how it was designed: a PD and the share of the way at
every sample. Derivatives by whatever they are designed from are one forward pass.

The residuals are no `LegMeasures`: a search by least squares takes many small ones that are
smooth, such as every eighth millisecond's distance from the mean, where a peak to peak would
hang on two samples. Nor is the offset among them a resting error, which is where the carriages
end: it is that mean's distance from the target.
"""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.sensors import Encoder
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.numerics.side_by_side import side_by_side
from scdpr_jax.robot.fields import si
from tuning.codesign.models import Models

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


@dataclasses.dataclass(frozen=True)
class Grid:
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


class Outcome(eqx.Module):
    """What a leg comes to; the first axis is the leg."""

    residuals: Float[Array | np.ndarray, "... residuals"] = eqx.field(metadata=si("1"))
    """What is wrong with it: their squares sum to its cost [1]."""
    measures: LegMeasures
    """Its measures."""

    @property
    def cost(self) -> Float[Array | np.ndarray, "..."]:
        """Sum of the squared residuals [1]."""
        return (self.residuals**2).sum(axis=-1)


def run(models: Models, command: Command, on: Grid) -> Outcome:
    """Legs of any number of models.

    Args:
        models: The models.
        command: What the controller is told.
        on: The grid.

    Returns:
        What each comes to.
    """
    return side_by_side(
        lambda few: _chunk(few, command, on), models, size=LANES, program=(_chunk, on)
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
        lambda few: _sloped(few, command, directions, on),
        models,
        size=SLOPED_LANES,
        program=(_sloped, on, directions.share.shape[0]),
    )


@functools.partial(jax.jit, static_argnames="on")
def _chunk(models: Models, command: Command, on: Grid) -> Outcome:
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


def _leg(model: Models, command: Command, on: Grid) -> Outcome:
    start = model.ensemble.position
    commanded = start[None] + command.share[:, None] * (model.end - start)[None]
    commands = Commands(
        controller=command.controller,
        reference=commanded,
        commanded=commanded,
        afterwards=jnp.arange(commanded.shape[0]) >= on.moving,
    )
    leg = run_leg(
        model.ensemble.robot, model.ensemble.start, commands, encoder=Encoder(on.counts)
    )
    resting = leg.pose[on.moving :, 0]
    size = jnp.max(jnp.abs(leg.voltage), axis=1) / model.ensemble.robot.drive.voltage_limit
    error = leg.measures.largest_error
    return Outcome(_residuals(resting, model.end[0], error, size, on), leg.measures)


def _residuals(
    resting: Float[Array, " resting"],
    target: Float[Array, ""],
    error: Float[Array, ""],
    size: Float[Array, " intervals"],
    on: Grid,
) -> Float[Array, " residuals"]:
    every = round(_LOOKED_AT / on.period)
    seen = resting[::every]
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
