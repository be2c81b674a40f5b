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
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import Motion, inverse_dynamics
from tuning.plan.following import Followed, Scenario, begin, follow
from tuning.plan.least_squares import Linearisation, least_squares
from tuning.plan.leg import Basis, plain_motion, spline_basis, with_deviation

LEG_TIME = 2.0
"""Time of a leg that is not asked for otherwise, if the drives can [s]."""
HOLD = 0.8
"""Time after the leg that is looked at [s]: two and a half periods of 3 Hz."""
SHORTEST = 0.5
"""Shortest time of a leg that is planned [s]."""
REST = 0.08
"""Time at the end of a leg in which the lower carriage already holds, and everything is to
be at rest: the upper carriage takes some 60 ms of it for its last millimetre [s]."""
STEP = 5e-3
"""Step of the search [s]; the plan itself is made at the controller's period."""
SPLINE_WIDTH = 0.11
"""Time between the knots of the lower carriage's deviation [s]."""

SCENARIOS = (
    (1.0, 1.0, 0.0),
    (1.03, 1.0, 0.0),
    (0.97, 1.0, 0.0),
    (1.0, 1.2, 0.0),
    (1.0, 0.8, 0.0),
    (1.0, 1.0, 0.3),
    (1.0, 1.0, -0.3),
)
"""Robots and starts that a plan is made for, `Scenario` by its fields [1]: the fitted one,
tensions and friction forces about it, and starts that friction holds out of line."""
WEIGHTS = (3.0, 1.0, 1.0, 1.5, 1.5, 0.3, 0.3)
"""How much each counts [1]."""

_VIBRATION = 0.3e-3
"""Distance from where it rests, once the drives hold, that counts as one [m]."""
_RESTING = 1e-3
"""Distance of that place from the target that counts as one [m]: friction that isn't known
decides it more than any motion does."""
_TRACKING = 100e-3
"""Distance from the plain profile during the leg that counts as one [m]."""
ORDERS = (2, 4, 6, 8, 10)
"""Orders of the plain profile's `pace` to choose from, the paper's first [1]."""
_PLAIN_SHARE = 0.92
"""Share of the voltage limit that the plain profile may ask for [1]: the PD answers a count of
the encoders with some 0.6 V, and a saturated drive doesn't follow."""
_VOLTAGE_SHARE = 0.85
"""Share of the voltage limit beyond which commands cost; the rest is the PD's [1]."""
_VOLTAGE = 0.5
"""Excess of a command that counts as one [V]."""
_OUTSIDE = 1e-3
"""How far out of the frame the lower carriage counts as one [m]."""
_ROUGHNESS = 0.5
"""Second difference of the splines' coefficients that counts as one [m]."""
_ARRIVAL = 0.1e-3
"""Distance of the fitted robot from rest at the target that counts as one, when a first
guess is sought [m]; velocities count over an angular frequency of 3 Hz."""

Progress = Callable[[str, float], None]


class Grid(NamedTuple):
    """What a leg is computed on, all of it but the unknowns."""

    instants: Motion
    """The plain profile at the beginnings of the intervals."""
    middles: Motion
    """The plain profile in the middles of the intervals."""
    ends: Float[Array, "intervals 2"]
    """The plain profile's position at the ends of the intervals [m]."""
    basis: tuple[Basis, Basis]
    """The splines at the beginnings and in the middles."""
    period: Float[Array, ""]
    """Length of the intervals [s]."""


def grid(
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    *,
    pace: "Pace",
    steps: int,
    hold: int,
) -> Grid:
    """The grid of a leg.

    Args:
        start: First position of the end-effector [m].
        end: Last position [m].
        pace: Time and plain profile of the leg.
        steps: Intervals in the leg.
        hold: Intervals after it.

    Returns:
        The grid.
    """
    leg_time, moving = pace.leg_time, pace.leg_time - REST
    period = leg_time / steps
    begins = period * np.arange(steps + hold)
    # One more instant than intervals: the profile's own end is exact.
    instants = [begins, begins + period / 2, begins + period]
    whole, shorter = (
        functools.partial(
            plain_motion,
            jnp.asarray(start),
            jnp.asarray(end),
            leg_time=jnp.asarray(time),
            order=pace.order,
        )
        for time in (leg_time, moving)
    )
    at_begin, at_middle = (
        # The height has nothing to wait for: it takes the whole leg.
        jax.tree.map(
            lambda x, y: jnp.stack([x[:, 0], y[:, 1]], axis=1),
            shorter(time=jnp.asarray(time)),
            whole(time=jnp.asarray(time)),
        )
        for time in instants[:2]
    )
    ends = whole(time=jnp.asarray(instants[2])).position
    splines = max(round(moving / SPLINE_WIDTH), 4)
    curves = tuple(spline_basis(moving, time, splines=splines) for time in instants[:2])
    return Grid(at_begin, at_middle, ends, curves, jnp.asarray(period))


def led(on: Grid, coefficients: Float[Array, " splines"]) -> tuple[Motion, Motion]:
    """The commanded motion at the intervals' beginnings and middles.

    Args:
        on: The grid.
        coefficients: Coefficients of the splines [m].

    Returns:
        Both.
    """
    first, second = on.basis
    return (
        with_deviation(on.instants, first, coefficients),
        with_deviation(on.middles, second, coefficients),
    )


def run_scenario(
    robot: Robot,
    controller: PD,
    scenario: Scenario,
    on: Grid,
    coefficients: Float[Array, " splines"],
) -> Followed:
    """A scenario's robot on a leg, its own dynamics inverted.

    The encoders show no start out of line: the motion is relative to where it begins.

    Args:
        robot: The fitted robot.
        controller: The PD controller.
        scenario: The scenario.
        on: The grid.
        coefficients: Coefficients of the splines [m].

    Returns:
        The run.
    """
    itself, state = begin(robot, scenario, on.instants.position[0])
    shift = (state.position[jnp.asarray((2, 4))] - on.instants.position[0])[None]
    instants, middles = (
        Motion(motion.position + shift, motion.velocity, motion.acceleration)
        for motion in led(on, coefficients)
    )
    return follow(
        itself, controller, state, instants=instants, middles=middles, period=on.period
    )


class _Outcome(NamedTuple):
    """What the scenarios' runs come to, in SI units, every fourth sample of them."""

    after: Float[Array, "scenarios samples"]
    """Distance of $x_e$ from the target once the drives hold [m]."""
    during: Float[Array, "scenarios samples"]
    """Distance of $x_e$ from the plain profile until then [m]."""
    excess: Float[Array, "scenarios samples"]
    """Commands beyond what is left to the PD [V]."""
    arrival: Float[Array, "scenarios 6"]
    """State of $[x_e, \\delta_e, q_4]$ as the drives stop, less rest in line [m, rad and m/s,
    rad/s]. As long as both carriages slide it is linear in the motion."""
    outside: Float[Array, " samples"]
    """How far the lower carriage is led out of the frame [m]."""


@functools.partial(jax.jit, static_argnames="holding")
def _linearised(
    robot: Robot,
    controller: PD,
    scenarios: Scenario,
    on: Grid,
    coefficients: Float[Array, " splines"],
    *,
    holding: int,
) -> tuple[_Outcome, _Outcome]:
    """The outcome and its Jacobian, by forward mode through every stop and start."""

    def outcome(coefficients: Float[Array, " splines"]) -> _Outcome:
        runs = jax.vmap(lambda one: run_scenario(robot, controller, one, on, coefficients))
        return _judge(robot, runs(scenarios), on, coefficients, holding=holding)

    directions = jnp.eye(coefficients.size, dtype=coefficients.dtype)
    return jax.vmap(
        lambda direction: jax.jvp(outcome, (coefficients,), (direction,)),
        out_axes=(None, -1),
    )(directions)


def _judge(
    robot: Robot,
    runs: Followed,
    on: Grid,
    coefficients: Float[Array, " splines"],
    *,
    holding: int,
) -> _Outcome:
    x, goal = runs.states.position[:, :, 0], on.ends[-1, 0]
    plain = on.ends[: holding - 1 : 4, 0][None]
    moving = jnp.asarray((0, 1, 3))
    target = jnp.stack([goal, jnp.zeros_like(goal), goal])[None]
    away = runs.states.position[:, holding - 1][:, moving] - target
    speed = runs.states.velocity[:, holding - 1][:, moving]
    excess = jnp.abs(runs.voltage[:, ::4]) - _VOLTAGE_SHARE * robot.drive.voltage_limit
    lower = led(on, coefficients)[0].position[::4, 0]
    return _Outcome(
        after=x[:, holding - 1 :: 4] - goal,
        during=x[:, : holding - 1 : 4] - plain,
        excess=jnp.maximum(excess, 0.0).reshape(x.shape[0], -1),
        arrival=jnp.concatenate([away, speed], axis=1),
        outside=jnp.maximum(-lower, 0.0) + jnp.maximum(lower - robot.frame.width, 0.0),
    )


class Pace(NamedTuple):
    """How fast a leg is, but for what the plan adds."""

    leg_time: float
    """Time of the leg [s]."""
    order: int
    """Order of its plain profile, `tuning.plan.leg.pace`."""


class Leg(NamedTuple):
    """A planned leg at the controller's period, from 0 to the leg's end inclusive."""

    time: Float[np.ndarray, " samples"]
    """Times [s]."""
    position: Float[np.ndarray, "samples 2"]
    """Where the end-effector is to be, $[x_e, y_e]$ [m]."""
    driven: Float[np.ndarray, "samples 2"]
    """Where lower carriage and height are to be, $[q_3, y_e]$ [m]."""
    feedforward: Float[np.ndarray, "samples 2"]
    """Commands beside the PD's, held until the next sample [V]."""


def plan_leg(
    robot: Robot,
    controller: PD,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    leg_time: float | None = None,
    iterations: int = 30,
    progress: Progress = lambda doing, share: None,
) -> Leg:
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
        The leg.

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
    found = _search(robot, controller, first, last, pace, iterations, progress)
    progress("commands at the controller's period", 0.9)
    return _at_full_rate(robot, controller, first, last, pace, found)


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
    weights = np.asarray(WEIGHTS)
    holding = steps - round(REST / leg_time * steps)
    on = grid(start, end, pace=pace, steps=steps, hold=round(HOLD / leg_time * steps))
    robots = scenarios()

    def linearised(goal: _Goal, point: Float[np.ndarray, " n"]) -> Linearisation:
        found = _linearised(robot, controller, robots, on, jnp.asarray(point), holding=holding)
        value, slope = (_Outcome(*(np.asarray(part) for part in parts)) for parts in found)
        rough = np.diff(np.eye(point.size), 2, axis=0) / _ROUGHNESS
        pairs = [*_common(value, slope, weights), *goal(value, slope, weights)]
        pairs.append((rough @ point, rough))
        return (
            np.concatenate([part.reshape(-1) for part, _ in pairs]),
            np.concatenate([part.reshape(-1, point.size) for _, part in pairs]),
        )

    plain = np.zeros(on.basis[0].value.shape[1])
    progress("compiling, or from the cache", 0.0)
    guess = least_squares(
        functools.partial(linearised, _arriving),
        plain,
        iterations=iterations,
        progress=lambda share: progress("a first guess", 0.1 + 0.3 * share),
    ).point
    return least_squares(
        functools.partial(linearised, _resting),
        guess,
        iterations=iterations,
        progress=lambda share: progress("motion", 0.4 + 0.5 * share),
    ).point


_Pairs = list[tuple[np.ndarray, np.ndarray]]
"""Residuals with their Jacobians."""
_Goal = Callable[[_Outcome, _Outcome, np.ndarray], _Pairs]


def _common(
    value: _Outcome, slope: _Outcome, weights: Float[np.ndarray, " scenarios"]
) -> _Pairs:
    """What every search minds: the plain profile, the drives' limit, the frame."""
    return [
        _weighted(value.during, slope.during, weights / _TRACKING),
        _weighted(value.excess, slope.excess, weights / _VOLTAGE),
        (value.outside / _OUTSIDE, slope.outside / _OUTSIDE),
    ]


def _resting(
    value: _Outcome, slope: _Outcome, weights: Float[np.ndarray, " scenarios"]
) -> _Pairs:
    """Rest for all scenarios, and at the target."""
    resting, its_slope = (part.after.mean(axis=1, keepdims=True) for part in (value, slope))
    count = np.sqrt(value.after.shape[1])
    return [
        _weighted(value.after - resting, slope.after - its_slope, weights / _VIBRATION),
        _weighted(count * resting, count * its_slope, weights / _RESTING),
    ]


def _arriving(
    value: _Outcome, slope: _Outcome, weights: Float[np.ndarray, " scenarios"]
) -> _Pairs:
    """Rest in line for the fitted robot, as the leg ends: it leads to the valley."""
    # Rotations count by the attachments' way, the light upper carriage by less.
    scale = np.tile((1.0, 0.1, 0.3), 2) / _ARRIVAL
    scale[3:] /= 2 * np.pi * 3.0
    return [(value.arrival[0] * scale, slope.arrival[0] * scale[:, None])]


def _weighted(
    value: np.ndarray, slope: np.ndarray, weights: Float[np.ndarray, " scenarios"]
) -> tuple[np.ndarray, np.ndarray]:
    return value * weights[:, None], slope * weights[:, None, None]


def _at_full_rate(
    robot: Robot,
    controller: PD,
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    pace: Pace,
    coefficients: Float[np.ndarray, " splines"],
) -> Leg:
    period = float(controller.period)
    steps = round(pace.leg_time / period)
    on = grid(start, end, pace=pace, steps=steps, hold=0)
    nominal = Scenario(*(jnp.asarray(number) for number in SCENARIOS[0]))
    run = _run_scenario(robot, controller, nominal, on, jnp.asarray(coefficients))
    driven = np.asarray(led(on, jnp.asarray(coefficients))[0].position)
    seen = np.asarray(run.states.position)[:, [0, 4]]
    last = np.zeros((1, 2))
    return Leg(
        time=period * np.arange(steps + 1),
        position=np.concatenate([start[None], seen[:-1], end[None]]),
        driven=np.concatenate([driven, end[None]]),
        feedforward=np.concatenate([np.asarray(run.feedforward), last]),
    )


_run_scenario = jax.jit(run_scenario)


def scenarios() -> Scenario:
    """The robots and starts of `SCENARIOS`, stacked.

    Returns:
        One of each along the first axis.
    """
    return Scenario(*(jnp.asarray(column) for column in zip(*SCENARIOS, strict=True)))


def chosen_pace(
    robot: Robot,
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    leg_time: float | None,
) -> Pace:
    """The first plain profile of `ORDERS` that the drives can follow in a leg's time.

    Args:
        robot: The robot.
        start: First position [m].
        end: Last position [m].
        leg_time: Time of the leg [s]; None for `LEG_TIME`, or as many tenths more as the
            drives need.

    Returns:
        Time and profile; where none can be followed in the time that was asked for, the one
        that asks the least of the drives.
    """
    most = _PLAIN_SHARE * float(robot.drive.voltage_limit)
    time = LEG_TIME if leg_time is None else leg_time
    while True:
        volts = [_plain_voltage(robot, start, end, Pace(time, order)) for order in ORDERS]
        if min(volts) <= most or leg_time is not None:
            first = next((k for k, v in enumerate(volts) if v <= most), int(np.argmin(volts)))
            return Pace(time, ORDERS[first])
        time = round(time + 0.1, 1)


def _plain_voltage(
    robot: Robot, start: Float[np.ndarray, "2"], end: Float[np.ndarray, "2"], pace: Pace
) -> float:
    """Largest command of the plain profile, the robot in line [V]."""
    still = Scenario(*(jnp.asarray(number) for number in SCENARIOS[0]))
    time = jnp.linspace(0.0, pace.leg_time, 41)[:-1]
    motion = plain_motion(
        jnp.asarray(start),
        jnp.asarray(end),
        leg_time=jnp.asarray(pace.leg_time),
        time=time,
        order=pace.order,
    )
    _, state = begin(robot, still, jnp.asarray(start))
    volts = jax.vmap(lambda moment: inverse_dynamics(robot, state, moment))(motion)
    return float(jnp.max(jnp.abs(volts)))
