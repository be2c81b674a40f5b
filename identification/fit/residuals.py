"""What a logged run and its simulation differ by, in standard deviations of the noise."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.data.record import Record
from scdpr_jax.engines.closed_loop import pulley_angles
from scdpr_jax.engines.stepping import Inputs, interpolate, simulate
from scdpr_jax.robot.dynamics import State, rest
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot


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
    knock_arm: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "h"))
    """Height above the centre of mass at which it acts [m]."""
    clock_offset: Float[Array, "..."] = eqx.field(converter=real, metadata=si("s"))
    """Camera time minus drive time at the run's first row, beyond what the log says [s]."""
    clock_drift: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1"))
    """By how much the camera's clock runs faster than the drives' [1]."""


class Residuals(NamedTuple):
    """Measurement minus simulation over the noise's standard deviation [1]."""

    angle: Float[Array, "rows 2"]
    """Of the encoders; their arbitrary zero is taken out."""
    frame: Float[Array, "frames 5"]
    """Of the camera."""
    known: Float[Array, "6"]
    """Of what is known before: start of both carriages and of the height, the knock's arm, the
    clock's offset and drift."""


class Motion(NamedTuple):
    """A run as the robot would do it, at the rows of the drive's stream."""

    states: State
    """The robot."""
    angle: Float[Array, "rows 2"]
    """Encoder angles from the start's [rad]."""
    inputs: Inputs
    """What acted on it."""


def move(robot: Robot, circumstances: Circumstances, record: Record) -> Motion:
    """The run as the robot would do it.

    Args:
        robot: The robot, with exact Coulomb friction.
        circumstances: What belongs to this run alone; the clock has no part in it.
        record: The run.

    Returns:
        Its motion.
    """
    robot = eqx.tree_at(lambda r: r.end_effector.knock_arm, robot, circumstances.knock_arm)
    start = rest(robot, circumstances.lower, circumstances.upper, circumstances.height)
    inputs = eqx.tree_at(
        lambda i: i.knock, record.inputs, circumstances.knock * record.inputs.knock
    )
    states = simulate(robot, start, inputs)
    return Motion(
        states, jax.vmap(lambda state: pulley_angles(robot, state, start))(states), inputs
    )


def frames(
    motion: Motion, circumstances: Circumstances, record: Record
) -> Float[Array, "frames 5"]:
    """What the camera would see of a motion.

    Args:
        motion: The motion.
        circumstances: What belongs to this run alone, of which the clock matters.
        record: The run.

    Returns:
        Positions at the camera's stamps [m, rad, m, m, m].
    """
    inputs = motion.inputs
    ends = jnp.cumsum(inputs.duration)
    instant = drive_time(
        record.frame_time, circumstances.clock_offset, circumstances.clock_drift
    )
    interval = jnp.clip(jnp.searchsorted(ends, instant), 0, ends.size - 1)
    duration = inputs.duration[interval]
    into = instant - (ends[interval] - duration)
    fraction = jnp.clip(into / jnp.where(duration > 0, duration, 1.0), 0.0, 1.0)
    return interpolate(motion.states, inputs, interval=interval, fraction=fraction)


def drive_time(
    stamp: Float[Array | np.ndarray, "..."],
    offset: Float[Array, ""] | float,
    drift: Float[Array, ""] | float,
) -> Float[Array | np.ndarray, "..."]:
    """Instants of the drives' clock at stamps of the camera's.

    Args:
        stamp: Stamps, less what was known of the clock before [s].
        offset: Camera time minus drive time at the run's first row, beyond that [s].
        drift: By how much the camera's clock runs faster [1].

    Returns:
        Instants since the run's first row [s].
    """
    return (stamp - offset) / (1 + drift)


def residuals(motion: Motion, circumstances: Circumstances, record: Record) -> Residuals:
    """Measurement minus simulation over the noise's standard deviation.

    Args:
        motion: The run as the robot would do it.
        circumstances: What belongs to this run alone.
        record: The run.

    Returns:
        Residuals; zero where nothing was measured.
    """
    own = circumstances
    assumed = jnp.stack(
        [
            own.lower,
            own.upper,
            own.height,
            own.knock_arm,
            own.clock_offset,
            own.clock_drift,
        ]
    )
    frame = frames(motion, own, record)
    return Residuals(
        angle=encoder_residuals(record.angle - motion.angle, record.angle_weight),
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
