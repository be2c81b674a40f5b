"""What a logged run and its simulation differ by, in standard deviations of the noise."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.data.circumstances import Circumstances
from identification.data.record import Record
from identification.fit.unknowns.unknowns import apply_run
from scdpr_jax.engines.closed_loop import pulley_angles
from scdpr_jax.engines.stepping import Inputs, interpolate, simulate
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State, rest


class Residuals(NamedTuple):
    """Measurement minus simulation over the noise's standard deviation [1]."""

    angle: Float[Array, "rows 2"]
    """Of the encoders; their arbitrary zero is taken out."""
    frame: Float[Array, "frames 5"]
    """Of the camera."""
    prior: Float[Array, " circumstances"]
    """Of what is known of the circumstances before."""


jax.export.register_namedtuple_serialization(Residuals, serialized_name="Residuals")


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
    start = begun(robot, circumstances)
    inputs = eqx.tree_at(
        lambda i: i.knock, record.inputs, circumstances.knock * record.inputs.knock
    )
    states = simulate(robot, start, inputs)
    return Motion(
        states, jax.vmap(lambda state: pulley_angles(robot, state, start))(states), inputs
    )


def begun(robot: Robot, circumstances: Circumstances) -> State:
    """The state that a run begins with.

    Args:
        robot: The robot.
        circumstances: What belongs to this run alone.

    Returns:
        The robot between its carriages at rest, or as it moves past.
    """
    still = rest(robot, circumstances.lower, circumstances.upper, circumstances.height)
    motion = circumstances.beginning
    if motion is None:
        return still
    radius = robot.drive.effective_radius
    first, second = motion.drive_1_speed, motion.drive_2_speed
    lower, height = radius * (first + second) / 2, radius * (first - second) / 2
    return State(
        still.position.at[:2].add(jnp.stack([motion.aside, motion.tilt])),
        jnp.stack([motion.speed, motion.turning, lower, motion.upper_speed, height]),
    )


def run_motion(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " of_run"], record: Record
) -> tuple[Motion, Circumstances]:
    """The run as the robot that a fit's unknowns stand for would do it.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        Its motion, and its circumstances.
    """
    robot, circumstances = apply_run(robot, free, unknown)
    return move(robot, circumstances, record), circumstances


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
    frame = frames(motion, circumstances, record)
    return Residuals(
        angle=encoder_residuals(record.angle - motion.angle, record.angle_weight),
        frame=record.frame_weight * (record.frame - frame),
        prior=record.prior.residuals(circumstances),
    )


Predicted = tuple[
    Float[Array | np.ndarray, "*runs rows 5"],
    Float[Array | np.ndarray, "*runs rows 2"],
    Float[Array | np.ndarray, "*runs frames 5"],
]
"""Positions at the drive's rows, encoder angles, and positions at the camera's stamps."""


def predicted(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " of_run"], record: Record
) -> Predicted:
    """A run with the cable on as the robot would do it.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.
        record: The run.

    Returns:
        Positions at the drive's rows, encoder angles there, and positions at the camera's
        stamps [m, rad, m, m, m].
    """
    motion, circumstances = run_motion(robot, free, unknown, record)
    return motion.states.position, motion.angle, frames(motion, circumstances, record)


def encoder_residuals(
    difference: Float[Array, "rows 2"], weight: Float[Array, "rows 2"]
) -> Float[Array, "rows 2"]:
    """Differences of encoder angles over the noise, their arbitrary zero taken out.

    Args:
        difference: Measured minus simulated angles [rad].
        weight: Inverse standard deviations [1/rad].

    Returns:
        Residuals about the zero that fits best; 0 where nothing was measured [1].
    """
    square = jnp.square(weight)
    total = jnp.sum(square, axis=0, keepdims=True)
    weighed = jnp.sum(square * difference, axis=0, keepdims=True)
    zero = weighed / jnp.where(total > 0, total, 1.0)
    return weight * (difference - zero)
