"""A robot that follows a commanded motion under feed-forward and PD."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, saturate
from scdpr_jax.engines.stepping import Inputs, step
from scdpr_jax.numerics.lean_scan import lean_scan
from scdpr_jax.robot.dynamics import State, rest
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.kinematics import inverse_kinematics
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import DRIVEN, Motion, inverse_dynamics


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
    coordinates = jnp.asarray(DRIVEN)
    radius = robot.drive.effective_radius
    still = jnp.zeros((), dtype=period.dtype)

    def advance(
        state: State, wanted: tuple[Motion, Motion]
    ) -> tuple[State, tuple[State, Float[Array, "2"], Float[Array, "2"]]]:
        now, ahead = wanted
        error = inverse_kinematics(now.position - state.position[coordinates], radius)
        rate = inverse_kinematics(now.velocity - state.velocity[coordinates], radius)
        forward = inverse_dynamics(robot, state, ahead)
        voltage = (
            forward + controller.proportional_gain * error + controller.derivative_gain * rate
        )
        held = Inputs(period, saturate(voltage, robot.drive.voltage_limit), still)
        following = step(robot, state, held)
        return following, (following, forward, voltage)

    _, (states, forward, voltage) = lean_scan(advance, start, (instants, middles))
    return Followed(states, forward, voltage)


class Scenario(eqx.Module):
    """A robot as it might be, and how its upper carriage lies before a leg."""

    tension: Float[Array, "..."] = eqx.field(metadata=si("1"))
    """Effective pretension over the fitted one [1]."""
    friction: Float[Array, "..."] = eqx.field(metadata=si("1"))
    """Friction force of the carriages over the fitted one [1]."""
    slope: Float[Array, "..."] = eqx.field(metadata=si("1"))
    r"""Slope of the line between the carriages over what friction holds, $\\mu$ [1]."""


def begin(robot: Robot, scenario: Scenario, position: Float[Array, "2"]) -> tuple[Robot, State]:
    """A scenario's robot, at rest with its end-effector at a position.

    Args:
        robot: The fitted robot.
        scenario: The scenario.
        position: Where the end-effector rests [m].

    Returns:
        The robot and its state.
    """
    coefficient = robot.lower_carriage.friction.coefficient
    changed = eqx.tree_at(
        lambda r: (
            r.cable.effective_pretension,
            r.lower_carriage.friction.coefficient,
            r.upper_carriage.friction.coefficient,
        ),
        robot,
        (
            robot.cable.effective_pretension * scenario.tension,
            coefficient * scenario.friction / scenario.tension,
            robot.upper_carriage.friction.coefficient * scenario.friction / scenario.tension,
        ),
    )
    slope = scenario.slope * coefficient
    x, y = position
    lower = x + slope * y
    return changed, rest(changed, lower, lower - slope * robot.frame.height, y)
