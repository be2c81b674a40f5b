"""What a plan is expected to come to: on robots as they might be, by the whole closed loop.

The search leads robots; this drives them: the engine with exact friction on both carriages and
in the drives, the sampled PD, the limit of the drives.
"""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.command.controller import PD, PDState, saturate
from scdpr_jax.engines.stepping import Inputs, step
from scdpr_jax.legs.ensemble import Variation
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.kinematics import inverse_kinematics
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State
from tuning.plan.leg import Leg
from tuning.plan.plan import Plan
from tuning.plan.search.scenarios import FARTHEST, FITTED, Scenarios

ROBOTS: tuple[Variation, ...] = (*FITTED, *FARTHEST)
"""The robots that a plan is judged on: one vector of the engine's lanes."""
AFTERWARDS = 1.0
"""Time after a leg in which vibration is looked at [s]: some periods of the slowest mode."""


@dataclasses.dataclass(frozen=True, eq=False)
class Expectation:
    """What a leg comes to on the robots that it is judged on, the fitted one first."""

    vibration: Float[np.ndarray, " robots"] = dataclasses.field(metadata=si("m"))
    """Peak to peak of the end-effector after the leg [m]."""
    resting: Float[np.ndarray, " robots"] = dataclasses.field(metadata=si("m"))
    """Where it rests, less the target, $x_e$ [m]."""

    @property
    def worst(self) -> float:
        """The largest vibration [m]."""
        return float(np.max(self.vibration))

    @property
    def mean(self) -> float:
        """The mean vibration [m]."""
        return float(np.mean(self.vibration))


class Told(NamedTuple):
    """What a controller is told in a period."""

    angle: Float[Array | np.ndarray, "... 2"]
    """Reference angles of the driver pulleys, from those at the begin [rad]."""
    feedforward: Float[Array | np.ndarray, "... 2"]
    """Commands beside the PD's [V]."""


class Loop(NamedTuple):
    """A closed loop of whole periods."""

    robot: Robot
    controller: PD
    begin: Float[Array | np.ndarray, "... 2"]
    """Where lower carriage and height are as the encoders show zero [m]."""


def sample(
    loop: Loop, carry: tuple[State, PDState], told: Told
) -> tuple[tuple[State, PDState], Float[Array, ""]]:
    """A period of the closed loop.

    Args:
        loop: The loop.
        carry: State of the robot and the controller's memory.
        told: What the controller is told.

    Returns:
        Both after the period, and the end-effector's place at its beginning [m].
    """
    (state, memory), drive = carry, loop.robot.drive
    angles = inverse_kinematics(state.driven - loop.begin, drive.effective_radius)
    memory, volts = loop.controller.step(memory, told.angle, angles)
    command = saturate(volts + told.feedforward, drive.voltage_limit)
    inputs = Inputs(loop.controller.period, command, 0.0 * loop.controller.period)
    return (step(loop.robot, state, inputs), memory), state.position[0]


def expectation(robots: Scenarios, controller: PD, leg: Leg, plan: Plan) -> Expectation:
    """What a plan is expected to come to.

    Args:
        robots: The robots that it is judged on, the fitted one first.
        controller: The controller, at the plan's period.
        leg: The leg, for its begin and its end.
        plan: The plan.

    Returns:
        Vibration and resting error.
    """
    return driven(robots.robot, controller, leg, plan, slope=leg.slope + robots.slope)


def driven(
    robots: Robot,
    controller: PD,
    leg: Leg,
    plan: Plan,
    *,
    slope: Float[np.ndarray, " robots"],
) -> Expectation:
    """What a plan comes to on any robots.

    Args:
        robots: The robots, stacked.
        controller: The controller, at the plan's period.
        leg: The leg, for where the end-effector begins and is to end.
        plan: The plan.
        slope: Slopes of the lines between their carriages at the begin [1].

    Returns:
        Vibration and resting error.
    """
    (x, y), top = leg.start, np.asarray(robots.frame.height)
    begin, height = x + slope * y, np.full(slope.size, y)
    undriven = (np.full(slope.size, x), np.arctan(slope))
    position = np.stack([*undriven, begin, x - slope * (top - y), height], axis=1)
    zero = np.zeros((1, 2))
    start = (State(position, np.zeros((1, 5))), PDState(zero, zero))
    held = ((0, round(AFTERWARDS / float(controller.period))), (0, 0))
    told_rows = (plan.angle, plan.feedforward)
    rows = Told(*(np.pad(own, held, mode="edge")[None] for own in told_rows))
    parts = (np.asarray(part, float)[None] for part in pd_numbers(controller))
    loop = Loop(robots, PD(*parts), np.stack([begin, height], axis=1))
    (last, _), x = native.Runs(sample, loop)(start, rows)
    after = x[:, plan.time.size - 1 :]
    lower, upper, height = (last.position[:, i] for i in (LOWER, UPPER, HEIGHT))
    rest = lower - (lower - upper) / top * height
    return Expectation(np.ptp(after, axis=1), rest - leg.end[0])


def pd_numbers(controller: PD) -> tuple[Array, ...]:
    """The numbers of a controller, in the order of its fields.

    Args:
        controller: The controller.

    Returns:
        Gains [V/rad; V s/rad], period and filter time [s].
    """
    return (
        controller.proportional_gain,
        controller.derivative_gain,
        controller.period,
        controller.filter_time,
    )
