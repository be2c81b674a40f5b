"""What a logged run and its simulation differ by, in standard deviations of the noise."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from identification.record import Record
from scdpr_jax.closed_loop import pulley_angles
from scdpr_jax.dynamics import State, rest
from scdpr_jax.fields import real, si
from scdpr_jax.parameters import Robot
from scdpr_jax.stepping import interpolate, simulate


class Circumstances(eqx.Module):
    """What belongs to one run alone and is estimated with the robot's parameters."""

    lower: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "q_3(0)"))
    """Start of the lower carriage [m]."""
    upper: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "q_4(0)"))
    """Start of the upper carriage [m]."""
    height: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "y_e(0)"))
    """Start of the end-effector's height [m]."""
    knock: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "F"))
    """Force of the knock while it lasts [N]."""
    clock_offset: Float[Array, "..."] = eqx.field(converter=real, metadata=si("s"))
    """Camera time minus drive time, beyond what the log says [s]."""


class Residuals(NamedTuple):
    """Measurement minus simulation over the noise's standard deviation [1]."""

    angle: Float[Array, "rows 2"]
    """Of the encoders; their arbitrary zero is taken out."""
    frame: Float[Array, "frames 5"]
    """Of the camera."""
    known: Float[Array, "4"]
    """Of what is known before: start of both carriages and of the height, clock."""


def predict(
    robot: Robot, circumstances: Circumstances, record: Record
) -> tuple[State, Float[Array, "rows 2"], Float[Array, "frames 5"]]:
    """The run as the robot would do it: states, encoder angles and camera positions.

    Args:
        robot: The robot, with exact Coulomb friction.
        circumstances: What belongs to this run alone.
        record: The run.

    Returns:
        States at the rows of the drive's stream, angles [rad] from the start's, and
        positions [m, rad, m, m, m] at the camera's stamps.
    """
    start = rest(robot, circumstances.lower, circumstances.upper, circumstances.height)
    inputs = eqx.tree_at(
        lambda i: i.knock, record.inputs, circumstances.knock * record.inputs.knock
    )
    states = simulate(robot, start, inputs)
    angles = jax.vmap(lambda state: pulley_angles(robot, state, start))(states)

    ends = jnp.cumsum(inputs.duration)
    instant = record.frame_time - circumstances.clock_offset
    interval = jnp.clip(jnp.searchsorted(ends, instant), 0, ends.size - 1)
    duration = inputs.duration[interval]
    into = instant - (ends[interval] - duration)
    fraction = jnp.clip(into / jnp.where(duration > 0, duration, 1.0), 0.0, 1.0)
    frames = interpolate(states, inputs, interval=interval, fraction=fraction)
    return states, angles, frames


def residuals(robot: Robot, circumstances: Circumstances, record: Record) -> Residuals:
    """Measurement minus simulation over the noise's standard deviation.

    Args:
        robot: The robot, with exact Coulomb friction.
        circumstances: What belongs to this run alone.
        record: The run.

    Returns:
        Residuals; zero where nothing was measured.
    """
    _, angle, frame = predict(robot, circumstances, record)
    own = circumstances
    assumed = jnp.stack([own.lower, own.upper, own.height, own.clock_offset])
    return Residuals(
        angle=encoder_residuals(record.angle - angle, record.angle_weight),
        frame=record.frame_weight * (record.frame - frame),
        known=record.known_weight * (record.known - assumed),
    )


def encoder_residuals(
    difference: Float[Array, "rows 2"], weight: Float[Array, "rows 2"]
) -> Float[Array, "rows 2"]:
    """Differences of encoder angles over the noise, their arbitrary zero taken out.

    Args:
        difference: Measured minus simulated angles [rad].
        weight: Inverse standard deviations [1/rad].

    Returns:
        Residuals about the zero that fits best [1].
    """
    square = jnp.square(weight)
    total = jnp.sum(square, axis=0, keepdims=True)
    zero = jnp.sum(square * difference, axis=0, keepdims=True) / total
    return weight * (difference - zero)
