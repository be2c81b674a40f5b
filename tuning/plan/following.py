"""A robot that follows a commanded motion under feed-forward and PD."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.command.controller import PD, saturate
from scdpr_jax.engines.stepping import Inputs, step
from scdpr_jax.robot.kinematics import inverse_kinematics
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State, driven
from tuning.plan.feedforward import Motion, inverse_dynamics


class Followed(NamedTuple):
    """A motion as it was followed."""

    states: State
    """States at the ends of the intervals."""
    feedforward: Float[Array, "intervals 2"]
    """Commands by dynamics inversion, held over the intervals, before saturation [V]."""
    voltage: Float[Array, "intervals 2"]
    """Commands with the PD's share, before saturation [V]."""


def follow(
    robot: Robot,
    controller: PD,
    start: State,
    *,
    instants: Motion,
    middles: Motion,
    period: Float[Array, ""],
) -> Followed:
    """A motion followed by dynamics inversion along the robot's own states.

    The PD works on velocities as they are: what it takes off is the error of holding a
    command over an interval.

    Args:
        robot: The robot.
        controller: The PD controller beside it; its period doesn't matter.
        start: State at the first instant.
        instants: The motion at the beginnings of the intervals.
        middles: The motion in the middles of the intervals.
        period: Length of the intervals [s].

    Returns:
        The run.
    """
    _, (states, forward, voltage) = native.run(
        _advance, (robot, controller, period), start, (instants, middles)
    )
    return Followed(states, forward, voltage)


def _advance(
    followed: tuple[Robot, PD, Float[Array, ""]],
    state: State,
    motion: tuple[Motion, Motion],
) -> tuple[State, tuple[State, Float[Array, "2"], Float[Array, "2"]]]:
    """An interval of the motion: where the robot ends, and its commands."""
    (robot, controller, period), (now, ahead) = followed, motion
    radius = robot.drive.effective_radius
    error = inverse_kinematics(now.position - state.driven, radius)
    rate = inverse_kinematics(now.velocity - driven(state.velocity), radius)
    forward = inverse_dynamics(robot, state, ahead)
    voltage = forward + controller.proportional_gain * error + controller.derivative_gain * rate
    limited = saturate(voltage, robot.drive.voltage_limit)
    following = step(robot, state, Inputs(period, limited, jnp.zeros_like(period)))
    return following, (following, forward, voltage)
