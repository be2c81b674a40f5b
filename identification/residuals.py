"""What a logged run and its simulation differ by, in standard deviations of the noise."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from identification.record import Record
from scdpr_jax.dynamics import State, rest
from scdpr_jax.fields import real, si
from scdpr_jax.parameters import Robot
from scdpr_jax.stepping import interpolate, simulate

TILT_SIGMA = 0.02
"""Standard deviation of the slope at which friction may leave the carriages [1].

A slope of up to the coefficient of friction can be held. Only a run without a camera
depends on it.
"""


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
    start: Float[Array, "3"]
    """Of the placement in x and y, and of the carriages' slope."""


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
    moved = states.position[:, jnp.array([2, 4])] - start.position[jnp.array([2, 4])]
    first = (moved[:, 0] + moved[:, 1]) / robot.drive.effective_radius
    second = (moved[:, 0] - moved[:, 1]) / robot.drive.effective_radius

    ends = jnp.cumsum(inputs.duration)
    instant = record.frame_time - circumstances.clock_offset
    interval = jnp.clip(jnp.searchsorted(ends, instant), 0, ends.size - 1)
    duration = inputs.duration[interval]
    into = instant - (ends[interval] - duration)
    fraction = jnp.clip(into / jnp.where(duration > 0, duration, 1.0), 0.0, 1.0)
    frames = interpolate(states, inputs, interval=interval, fraction=fraction)
    return states, jnp.stack([first, second], axis=-1), frames


def residuals(robot: Robot, circumstances: Circumstances, record: Record) -> Residuals:
    """Measurement minus simulation over the noise's standard deviation.

    Args:
        robot: The robot, with exact Coulomb friction.
        circumstances: What belongs to this run alone.
        record: The run.

    Returns:
        Residuals; zero where nothing was measured.
    """
    states, angle, frame = predict(robot, circumstances, record)
    weight = record.angle_weight[:, None]
    difference = record.angle - angle
    # The encoders' zero is arbitrary: the best one is the weighted mean.
    zero = jnp.sum(weight * difference, axis=0) / jnp.sum(weight)
    start = states.position[0]
    placed = (record.placement - start[jnp.array([0, 4])]) * record.placement_weight
    slope = (circumstances.lower - circumstances.upper) / robot.frame.height
    return Residuals(
        angle=weight * (difference - zero),
        frame=record.frame_weight * (record.frame - frame),
        start=jnp.append(placed, -slope / TILT_SIGMA),
    )
