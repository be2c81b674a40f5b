"""A planned leg, and the same leg as the paper runs it, simulated side by side."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from rich.table import Table

from scdpr_jax.closed_loop import ClosedLoop, closed_loop, joint_references
from scdpr_jax.controller import PD, published_pd
from scdpr_jax.dynamics import rest
from scdpr_jax.kinematics import forward_kinematics
from scdpr_jax.parameters import Robot
from scdpr_jax.trajectory import rest_to_rest
from tuning.plan_file import Plan
from tuning.planning import Progress, plan_leg

AFTERWARDS = 1.5
"""Time that is looked at after the leg [s]."""
SETTLED = 5e-3
"""Distance from the target within which a leg has settled [m]."""


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


@dataclasses.dataclass(frozen=True)
class LegFigures:
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


def compare(robot: Robot, controller: PD, plan: Plan) -> tuple[LegFigures, LegFigures]:
    """The leg as the paper runs it, and as planned, on the fitted robot.

    Args:
        robot: The fitted robot.
        controller: The PD controller of the plan.
        plan: The plan.

    Returns:
        Figures of the plain profile under the PD of Eq. (25), and of the plan.
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
    before = _figures(robot, published_pd(), plain, plain, nothing)
    return before, _figures(robot, controller, led, plan.position, plan.feedforward)


def _figures(
    robot: Robot,
    controller: PD,
    led: Float[np.ndarray, "samples 2"],
    reference: Float[np.ndarray, "samples 2"],
    feedforward: Float[np.ndarray, "samples 2"],
) -> LegFigures:
    held = ((0, round(AFTERWARDS / float(controller.period))), (0, 0))
    led, reference, feedforward = (
        np.pad(part, held, mode="edge") for part in (led, reference, feedforward)
    )
    run = _run(robot, controller, jnp.asarray(led), jnp.asarray(feedforward))
    q = np.asarray(run.states.position)
    ended = len(q) - held[0][1] - 1
    last = q[-1]
    slope = (last[3] - last[2]) / float(robot.frame.height)
    goal = reference[-1]
    away = np.hypot(*(q[:, [0, 4]] - goal).T)
    unsettled = np.flatnonzero(away > SETTLED)
    first = unsettled[-1] + 1 if unsettled.size else 0
    time = np.asarray(run.time)
    return LegFigures(
        vibration=float(np.ptp(q[ended:, 0])),
        resting_error=float(np.hypot(last[2] + slope * last[4] - goal[0], last[4] - goal[1])),
        settled=float(time[first]) if first < time.size else float("nan"),
        largest_error=float(np.max(np.hypot(*(q[:, [0, 4]] - reference).T))),
        largest_voltage=float(np.max(np.abs(np.asarray(run.voltage)))),
    )


@eqx.filter_jit
def _run(
    robot: Robot,
    controller: PD,
    led: Float[Array, "samples 2"],
    feedforward: Float[Array, "samples 2"],
) -> ClosedLoop:
    x, y = led[0]
    return closed_loop(
        robot, rest(robot, x, x, y), controller, reference=led, feedforward=feedforward
    )


def comparison_table(compared: tuple[LegFigures, LegFigures]) -> Table:
    """The figures of both, for the terminal.

    Args:
        compared: What `compare` returns.

    Returns:
        The table.
    """
    table = Table(title="The leg, simulated on the fitted robot", title_justify="left")
    for head in (
        "",
        "vibration after it [mm]",
        "resting error [mm]",
        "within 5 mm from [s]",
        "largest error, Eq. (26) [mm]",
        "largest command [V]",
    ):
        table.add_column(head, justify="right" if head else "left")
    for name, one in zip(("plain profile, Eq. (25)", "planned"), compared, strict=True):
        table.add_row(
            name,
            f"{1e3 * one.vibration:.2f}",
            f"{1e3 * one.resting_error:.2f}",
            f"{one.settled:.3f}",
            f"{1e3 * one.largest_error:.1f}",
            f"{one.largest_voltage:.2f}",
        )
    return table
