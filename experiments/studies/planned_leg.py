"""A planned leg, and the same leg as the paper runs it, simulated side by side."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.engines.closed_loop import ClosedLoop, closed_loop, joint_references
from scdpr_jax.robot.kinematics import forward_kinematics
from scdpr_jax.robot.parameters import Robot
from tuning.plan.following import Scenario, begin
from tuning.plan.plan_file import Plan
from tuning.plan.planning import SCENARIOS, Progress, plan_leg, scenarios

AFTERWARDS = 1.5
"""Time that is looked at after the leg [s]."""
SETTLED = 5e-3
"""Distance from the target within which a leg has settled [m]."""
SIDES = ("plain profile, Eq. (25)", "planned")
"""Names of what is compared, for tables and legends."""


def make(
    robot: Robot,
    controller: PD,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    leg_time: float | None,
    progress: Progress,
) -> Plan:
    """Plan a leg.

    Args:
        robot: The fitted robot.
        controller: The PD controller that it will run under.
        start: Where the end-effector rests [m].
        end: Where it is to go [m].
        leg_time: Time of the leg [s]; None for the planner's choice.
        progress: Told what is being done and which share of it is done.

    Returns:
        The plan.
    """
    leg = plan_leg(robot, controller, start, end, leg_time=leg_time, progress=progress)
    angle = np.asarray(joint_references(robot, jnp.asarray(leg.driven)))
    return Plan(leg.time, leg.position, angle, leg.feedforward)


class LegFigures(NamedTuple):
    """What a simulated leg comes to."""

    vibration: float
    """Peak to peak of $x_e$ after the reference has ended [m]."""
    resting_error: float
    """Distance from the target to the line between the carriages, at rest [m]."""
    settled: float
    """When the end-effector stays within `SETTLED` of the target [s]; NaN if never."""
    largest_error: float
    """Largest error against its own reference, Eq. (26) [m]."""
    largest_voltage: float
    """Largest command [V]."""


class LegRun(NamedTuple):
    """A leg as it was simulated, held for `AFTERWARDS` at its end."""

    time: Float[np.ndarray, " samples"]
    """Times of the samples [s]."""
    reference: Float[np.ndarray, "samples 2"]
    """Where the end-effector was to be [m]."""
    position: Float[np.ndarray, "samples 2"]
    """Where it was, $[x_e, y_e]$ [m]."""
    voltage: Float[np.ndarray, "samples-1 2"]
    """Commands [V]."""
    figures: LegFigures
    """What it comes to."""


class Compared(NamedTuple):
    """A leg as the paper runs it and as planned, on the robots that it was planned for."""

    names: tuple[str, ...]
    """What is different about each robot, the fitted one first."""
    plain: tuple[LegRun, ...]
    """The plain profile under the PD of Eq. (25)."""
    planned: tuple[LegRun, ...]
    """The plan."""


def compare(robot: Robot, controller: PD, plan: Plan) -> Compared:
    """The leg as the paper runs it, and as planned, on the robots of `SCENARIOS`.

    Args:
        robot: The fitted robot.
        controller: The PD controller of the plan.
        plan: The plan.

    Returns:
        Both on every robot, in the time of the plan.
    """
    time = jnp.asarray(plan.time)
    leg = rest_to_rest(plan.position[0], plan.position[-1], duration=plan.time[-1])
    plain = np.asarray(jax.vmap(leg.position)(time))
    led = plan.position[0] + np.asarray(
        jax.vmap(lambda angle: forward_kinematics(angle, robot.drive.effective_radius))(
            jnp.asarray(plan.angle)
        )
    )
    nothing = np.zeros_like(plan.feedforward)
    return Compared(
        tuple(map(_told, SCENARIOS)),
        _runs(robot, published_pd(), plain, plain, nothing),
        _runs(robot, controller, led, plan.position, plan.feedforward),
    )


def _told(scenario: tuple[float, float, float]) -> str:
    """What is different about a robot of `SCENARIOS`, in words."""
    tension, friction, slope = scenario
    parts = [
        f"{name} {100 * (share - 1):+.0f} %".replace("-", "−")
        for name, share in (("pretension", tension), ("friction", friction))
        if share != 1
    ]
    if slope:
        side = "ahead" if slope > 0 else "behind"
        parts.append(f"lower carriage {abs(slope):g} μH {side} before")
    return ", ".join(parts) or "as fitted"


def _runs(
    robot: Robot,
    controller: PD,
    led: Float[np.ndarray, "samples 2"],
    reference: Float[np.ndarray, "samples 2"],
    feedforward: Float[np.ndarray, "samples 2"],
) -> tuple[LegRun, ...]:
    held = ((0, round(AFTERWARDS / float(controller.period))), (0, 0))
    led, reference, feedforward = (
        np.pad(part, held, mode="edge") for part in (led, reference, feedforward)
    )
    found = _simulated(
        robot, controller, scenarios(), jnp.asarray(led), jnp.asarray(feedforward)
    )
    runs, ended = [], len(led) - held[0][1] - 1
    for lane in range(len(SCENARIOS)):
        run = jax.tree.map(lambda leaf, lane=lane: np.asarray(leaf[lane]), found)
        q = run.states.position
        figures = _figures(q, reference, run.time, run.voltage, ended, robot)
        runs.append(LegRun(run.time, reference, q[:, [0, 4]], run.voltage, figures))
    return tuple(runs)


def _figures(
    q: Float[np.ndarray, "samples 5"],
    reference: Float[np.ndarray, "samples 2"],
    time: Float[np.ndarray, " samples"],
    voltage: Float[np.ndarray, "samples-1 2"],
    ended: int,
    robot: Robot,
) -> LegFigures:
    last, goal = q[-1], reference[-1]
    slope = (last[3] - last[2]) / float(robot.frame.height)
    unsettled = np.flatnonzero(np.hypot(*(q[:, [0, 4]] - goal).T) > SETTLED)
    first = unsettled[-1] + 1 if unsettled.size else 0
    return LegFigures(
        vibration=float(np.ptp(q[ended:, 0])),
        resting_error=float(np.hypot(last[2] + slope * last[4] - goal[0], last[4] - goal[1])),
        settled=float(time[first]) if first < time.size else float("nan"),
        largest_error=float(np.max(np.hypot(*(q[:, [0, 4]] - reference).T))),
        largest_voltage=float(np.max(np.abs(voltage))),
    )


@eqx.filter_jit
def _simulated(
    robot: Robot,
    controller: PD,
    each: Scenario,
    led: Float[Array, "samples 2"],
    feedforward: Float[Array, "samples 2"],
) -> ClosedLoop:
    def run(scenario: Scenario) -> ClosedLoop:
        might_be, start = begin(robot, scenario, led[0])
        return closed_loop(might_be, start, controller, reference=led, feedforward=feedforward)

    return jax.vmap(run)(each)
