r"""A leg that arrives without vibration, and in line: motion and feed-forward for the drives.

Friction makes what a shaper can't take away. It drags the upper carriage behind the lower
one, excites the modes when it starts and when it ends, and holds the upper carriage up to
$\mu H$ out of line for good. While both carriages slide it is a constant force, though, and
a motion of the lower carriage can bring everything to rest at one moment: that motion is
found by least squares through the simulation with exact friction, over a handful of robots
and start poses that the fit doesn't rule out.
"""

import functools
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.engines.closed_loop import joint_references
from scdpr_jax.legs.ensemble import Ensemble, Variation, single, varied
from scdpr_jax.native import kept_jit
from scdpr_jax.numerics.levenberg_marquardt import Damping, Stopping, minimise
from scdpr_jax.numerics.merit import SumOfSquares
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.parameters import Robot
from tuning.plan.grid import REST, Grid, grid, led
from tuning.plan.outcome import (
    Outcome,
    Pairs,
    arriving,
    common,
    linearised,
    resting,
    roughness,
    run_planned,
)
from tuning.plan.pace import Pace, chosen_pace
from tuning.plan.plan import Plan

HOLD = 0.8
"""Time after the leg that is looked at [s]: two and a half periods of 3 Hz."""
SHORTEST = 0.5
"""Shortest time of a leg that is planned [s]."""
STEP = 5e-3
"""Step of the search [s]; the plan itself is made at the controller's period."""

VARIATIONS = (
    Variation(weight=3.0),
    Variation(tension=1.03),
    Variation(tension=0.97),
    Variation(friction=1.2, weight=1.5),
    Variation(friction=0.8, weight=1.5),
    Variation(out_of_line=0.3, weight=0.3),
    Variation(out_of_line=-0.3, weight=0.3),
)
"""Robots and starts that a plan is made for: the fitted one, tensions and friction forces
about it, and starts that friction holds out of line."""

_DAMPING = Damping(fall=5.0, rise=4.0, floor=1e-9)
"""Damping of a search; the floor is for splines that move almost nothing."""
_REJECTIONS = 8
"""Dampings that are tried before a point counts as a minimum, or as a kink."""
_SAVING = 1e-3
"""Share of the misfit that a step has to save for the search to go on [1]."""


def plan_leg(
    robot: Robot,
    controller: PD,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    leg_time: float | None = None,
    iterations: int = 30,
    progress: Progress = SILENT,
) -> Plan:
    """The motion of one leg from rest to rest.

    Args:
        robot: The fitted robot, with exact friction.
        controller: The PD controller that it will run under.
        start: Where the end-effector rests [m].
        end: Where it is to go [m].
        leg_time: Time of the leg [s]; None for `LEG_TIME`, or where the drives can't the
            shortest in which they can.
        iterations: Steps of each search at the most.
        progress: Told what is being done and which share of it is done.

    Returns:
        The plan.

    Raises:
        ValueError: If the leg is too short to be planned.
    """
    if leg_time is not None and not leg_time >= SHORTEST:
        raise ValueError(
            f"`leg_time` is too short, got {leg_time:g} s, expected {SHORTEST:g} s or more: "
            "that is about one period of the slowest mode. Give the leg more time."
        )
    first, last = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    pace = chosen_pace(robot, first, last, leg_time)
    coefficients = _search(robot, controller, first, last, pace, iterations, progress)
    progress("commands at the controller's period", 0.9)
    return _at_full_rate(robot, controller, first, last, pace, coefficients)


def _search(
    robot: Robot,
    controller: PD,
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    pace: Pace,
    iterations: int,
    progress: Progress,
) -> Float[np.ndarray, " splines"]:
    leg_time = pace.leg_time
    steps = 100 * max(round(leg_time / (100 * STEP)), 1)
    holding = steps - round(REST / leg_time * steps)
    on = grid(start, end, pace=pace, steps=steps, hold=round(HOLD / leg_time * steps))
    robots = varied(robot, VARIATIONS, start)

    def misfit(goal: _Goal, point: Float[np.ndarray, " n"]) -> SumOfSquares:
        both = linearised(robots, controller, on, point, holding=holding)
        value, slope = jax.tree.map(np.asarray, both)
        pairs = [part for each in (common, goal) for part in each(value, slope, robots.weight)]
        pairs.append(roughness(point))
        return SumOfSquares(
            np.concatenate([part.reshape(-1) for part, _ in pairs]),
            np.concatenate([part.reshape(-1, point.size) for _, part in pairs]),
        )

    stopping = Stopping(steps=iterations, rejections=_REJECTIONS, saving=_SAVING, share=0.0)
    plain = np.zeros(on.basis[0].value.shape[1])
    progress("compiling, or from the cache", 0.0)
    guess = minimise(
        functools.partial(misfit, arriving),
        plain,
        stopping=stopping,
        damping=_DAMPING,
        progress=progress.part(0.1, 0.4, "a first guess"),
    ).point
    return minimise(
        functools.partial(misfit, resting),
        guess,
        stopping=stopping,
        damping=_DAMPING,
        progress=progress.part(0.4, 0.9, "motion"),
    ).point


_Goal = Callable[[Outcome, Outcome, np.ndarray], Pairs]


def _at_full_rate(
    robot: Robot,
    controller: PD,
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    pace: Pace,
    coefficients: Float[np.ndarray, " splines"],
) -> Plan:
    period = float(controller.period)
    steps = round(pace.leg_time / period)
    on = grid(start, end, pace=pace, steps=steps, hold=0)
    run = _run_planned(single(robot, start), controller, on, coefficients, end)
    places, angle, feedforward = map(np.asarray, run)
    return Plan(
        time=period * np.arange(steps + 1),
        position=np.concatenate([start[None], places[:-1], end[None]]),
        angle=angle,
        feedforward=np.concatenate([feedforward, np.zeros((1, 2))]),
    )


@kept_jit
def _run_planned(
    robot: Ensemble,
    controller: PD,
    on: Grid,
    coefficients: Float[Array, " splines"],
    end: Float[Array, "2"],
) -> tuple[Float[Array, "steps 2"], Float[Array, "steps+1 2"], Float[Array, "steps 2"]]:
    """Places at the ends of the intervals, the drives' angles, and the feed-forward."""
    run = run_planned(robot, controller, on, coefficients)
    along = jnp.concatenate([led(on, coefficients)[0].position, end[None]])
    return run.states.pose, joint_references(robot.robot, along), run.feedforward
