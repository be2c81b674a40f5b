r"""The fixed-grid engine: exact Coulomb friction, near fourth order, differentiable.

A step covers one interval of zero-order-held voltages. The smooth part is Butcher's
fifth-order Runge-Kutta on the branches that the contacts are on when the step begins. Where
one leaves its branch inside the step (it stops, turns round, sticks or breaks away), the
instant follows in closed form from the step's own polynomials, and the friction's deviation
acts through the robot's own response at frozen coefficients. The upper carriage has its
friction to itself (`scdpr_jax.contacts.single`); the lower carriage and both drives share
the pair $(\dot q_3, \dot y_e)$ (`scdpr_jax.contacts.branches`), whose events are followed
one by one (`scdpr_jax.contacts.events`): the only loop in a step, and passed over where no run
of a batch has an event.

Why so: logs have a grid of their own, held voltages jump at its instants, and a fit needs
derivatives of a program that is always the same. An adaptive solver places its steps by the
state, takes thousands of them where friction is smoothed narrowly enough to be right, and
loses its derivatives there. A projection of each step's end onto the friction's cone needs no
instants, but is of first order, and its derivatives are wrong by per cents at any step.

A carriage that sticks has a velocity of exactly zero, a drive that sticks has
$\dot q_3 = \mp\dot y_e$ exactly; that is the engine's only memory.
"""

from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from scdpr_jax import native
from scdpr_jax.contacts import branches, events, single
from scdpr_jax.contacts.branches import PAIR, Pair, Three, act, less
from scdpr_jax.contacts.motion import Assumed
from scdpr_jax.contacts.polynomial import Cubic, Quadratic, cubic_between
from scdpr_jax.contacts.response import Response, departed
from scdpr_jax.engines.arguments import (
    check_commands,
    check_shape,
    check_start,
    possible_substeps,
)
from scdpr_jax.engines.inputs import Inputs as Inputs
from scdpr_jax.engines.inputs import possible_inputs as possible_inputs
from scdpr_jax.robot.cable import carriage_stiffness, loop_forces
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import dampings, masses, smooth_forces
from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State, with_coordinates

_Run = TypeVar("_Run")


def simulate(robot: Robot, start: State, inputs: Inputs, *, substeps: int = 1) -> State:
    """Trajectory of the robot on the grid of its inputs.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        start: State at the first instant.
        inputs: Commands and knocks, one row for each of `n` intervals.
        substeps: Steps in an interval; the error falls with nearly their fourth power. Steps
            of 5 ms are good to a micrometre.

    Returns:
        States at the `n + 1` ends of the intervals, the start first.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If a shape is another, a duration is negative, `substeps` is below 1, or a
            number isn't finite or can't be a robot's; a negative duration that is traced gives
            NaN.
    """
    check_start(robot, start)
    check_commands(robot, inputs.voltage)
    interval = _Interval(robot, possible_substeps(substeps))
    _, states = native.run(_advance, interval, start, possible_inputs(inputs))
    return with_start(start, states)


def with_start(start: _Run, following: _Run) -> _Run:
    """What holds at the first instant and what follows it, as one run.

    Args:
        start: A state, or any tree of arrays.
        following: The same at the following instants, along the first axis.

    Returns:
        All of them.
    """
    return jax.tree.map(
        lambda first, rest: jnp.concatenate([first[None], rest]), start, following
    )


class _Interval(eqx.Module):
    """What an interval of held inputs needs to know."""

    robot: Robot
    substeps: int = eqx.field(static=True)
    """Steps in the interval."""


def _advance(interval: _Interval, state: State, held: Inputs) -> tuple[State, State]:
    """An interval whose end is carried on and told."""
    if interval.substeps == 1:
        following = step(interval.robot, state, held)
        return following, following
    part = Inputs(held.duration / interval.substeps, held.voltage, held.knock)
    following = jax.lax.fori_loop(
        0, interval.substeps, lambda _, now: step(interval.robot, now, part), state
    )
    return following, following


def interpolate(
    states: State,
    inputs: Inputs,
    *,
    interval: Int[Array, " frames"],
    fraction: Float[Array, " frames"],
) -> Float[Array, "frames 5"]:
    """Positions between the grid's instants: the cubic through positions and velocities.

    Args:
        states: States at the ends of the intervals.
        inputs: The inputs of that simulation.
        interval: The interval in which each wanted instant lies.
        fraction: Its place in the interval, from 0 to 1 [1].

    Returns:
        Positions at these instants [m, rad, m, m, m].
    """
    before, after = states.position[interval], states.position[interval + 1]
    duration = inputs.duration[interval][:, None]
    leaving = duration * states.velocity[interval]
    arriving = duration * states.velocity[interval + 1]
    s = fraction[:, None]
    quadratic = 3 * (after - before) - 2 * leaving - arriving
    cubic = 2 * (before - after) + leaving + arriving
    return before + s * (leaving + s * (quadratic + s * cubic))


def step(robot: Robot, state: State, inputs: Inputs) -> State:
    """The state after one interval.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        state: State at the beginning.
        inputs: Commands and knock of this one interval.

    Returns:
        State at the end; what sticks has a velocity, or a pulley's rate, of exactly zero.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If a shape is another.
    """
    check_shape(state.position, (5,), name="state.position", unit="m, rad")
    check_shape(state.velocity, (5,), name="state.velocity", unit="m/s, rad/s")
    check_shape(inputs.voltage, (2,), name="voltage", unit="V")
    check_shape(inputs.knock, (), name="knock", unit="N")
    stages = _runge_kutta(robot, state, inputs)
    responses = _responses(robot, state, inputs)
    mass = masses(robot)
    contacts = branches.Contacts(
        tuple(mass[i] for i in PAIR),
        tuple(inputs.duration * limit for limit in stages.middle.limit.pair),
    )
    upper = single.deviation(_upper_motion(inputs, stages, responses[UPPER]))
    pair = events.deviation(_pair_motion(inputs, stages, responses, mass), contacts)
    return departed(
        stages.end,
        (upper.departure(UPPER), pair.departure(contacts.mass)),
        duration=inputs.duration,
        responses=responses,
    )


def _responses(robot: Robot, state: State, inputs: Inputs) -> dict[int, Response]:
    """How the robot answers coordinates with friction, at frozen coefficients."""
    h, mass = inputs.duration, masses(robot)
    damped = h * dampings(robot) / mass
    lower, upper = -jnp.square(h) * carriage_stiffness(robot, state.position) / mass[None]
    # The height's stiffness is of second order in the inclinations.
    couplings = {LOWER: lower, UPPER: upper, HEIGHT: jnp.zeros_like(mass)}
    return {i: Response(damped[i], coupling) for i, coupling in couplings.items()}


_STAGES = (
    (1 / 4,),
    (1 / 8, 1 / 8),
    (0.0, -1 / 2, 1.0),
    (3 / 16, 0.0, 0.0, 9 / 16),
    (-3 / 7, 2 / 7, 12 / 7, -12 / 7, 8 / 7),
)
_END = (7 / 90, 0.0, 32 / 90, 12 / 90, 32 / 90, 7 / 90)
"""Butcher's fifth-order method, J. C. Butcher, J. Austral. Math. Soc. 4 (1964) 179-194,
doi:10.1017/S1446788700023387: its stages, and its end."""
_PLACES = (0, 3, 5)
"""The stages at the beginning, in the middle and at the end of the step."""


class _Limits(NamedTuple):
    """Largest frictions at a position."""

    upper: Float[Array, ""]
    """Of the upper carriage, over its mass [m/s²]."""
    pair: Three
    """Of both drives at their pulleys' rims, and of the lower carriage [N]."""


class _Stage(NamedTuple):
    """A stage of a Runge-Kutta step, with what acts over the masses [m/s², rad/s²]."""

    at: State
    load: Float[Array, "5"]
    """All but dry friction."""
    limit: _Limits
    slope: Float[Array, "5"]
    """Acceleration on the branches."""


class _Stages(NamedTuple):
    """A Runge-Kutta step on the branches that it began on."""

    upper: Float[Array, ""]
    """Branch of the upper carriage."""
    pair: branches.Branch
    """Branch of the lower carriage and the drives."""
    mobility: Three
    """That branch's [1/kg]."""
    beginning: _Stage
    middle: _Stage
    last: _Stage
    end: State

    @property
    def three(self) -> tuple[_Stage, _Stage, _Stage]:
        """The stages at the beginning, in the middle and at the end of the step."""
        return self.beginning, self.middle, self.last


def _runge_kutta(robot: Robot, start: State, inputs: Inputs) -> _Stages:
    mass = masses(robot)
    pair_mass = tuple(mass[i] for i in PAIR)
    torque = motor_torque(robot.drive, inputs.voltage)
    lower, upper = exact_laws(robot)
    drives = robot.drive.frictions / robot.drive.effective_radius

    def balance(at: State) -> tuple[Float[Array, "5"], _Limits]:
        loop = loop_forces(robot, at.position)
        force = smooth_forces(robot, loop, at.velocity, torque=torque, knock=inputs.knock)
        guide = lower.sliding(at.velocity[LOWER]) * loop.normal[0]
        alone = upper.sliding(at.velocity[UPPER]) * loop.normal[1] / mass[UPPER]
        return force / mass, _Limits(alone, (*drives, guide))

    def on_pair(load: Float[Array, "5"]) -> Pair:
        return tuple(load[i] * mass[i] for i in PAIR)

    load, limit = balance(start)
    branch = single.branch_at_start(start.velocity[UPPER], load[UPPER], limit.upper)
    pair = branches.branch_at_start(
        tuple(start.velocity[i] for i in PAIR),
        on_pair(load),
        branches.Contacts(pair_mass, limit.pair),
    )
    mobility = pair.mobility(pair_mass)

    def stage(at: State, load: Float[Array, "5"], limit: _Limits) -> _Stage:
        free = jnp.where(branch == 0, 0.0, load[UPPER] - branch * limit.upper)
        along, up = act(mobility, less(on_pair(load), pair.friction(limit.pair)))
        slope = with_coordinates(load, {LOWER: along, UPPER: free, HEIGHT: up})
        return _Stage(at, load, limit, slope)

    def ahead(weights: tuple[float, ...]) -> State:
        parts = [(inputs.duration * w, s) for w, s in zip(weights, stages, strict=True) if w]
        return State(
            start.position + sum(w * s.at.velocity for w, s in parts),
            start.velocity + sum(w * s.slope for w, s in parts),
        )

    stages = [stage(start, load, limit)]
    for weights in _STAGES:
        at = ahead(weights)
        stages.append(stage(at, *balance(at)))
    return _Stages(branch, pair, mobility, *(stages[i] for i in _PLACES), end=ahead(_END))


def _assumed_velocity(h: Float[Array, ""], stages: _Stages, i: int) -> Cubic:
    """A coordinate's velocity through the step."""
    return cubic_between(
        stages.beginning.at.velocity[i],
        stages.end.velocity[i],
        slope=h * stages.beginning.slope[i],
        end_slope=h * stages.last.slope[i],
    )


def _held_load(
    h: Float[Array, ""], stages: _Stages, i: int, damped: Float[Array, ""]
) -> Quadratic:
    """What friction must balance to hold a coordinate: no damping, as what is held rests."""
    first, middle, last = (
        h * stage.load[i] + damped * stage.at.velocity[i] for stage in stages.three
    )
    return Quadratic(first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle)


def _upper_motion(inputs: Inputs, stages: _Stages, response: Response) -> single.Assumed:
    """The upper carriage's assumed motion, as polynomials in the step's time."""
    h = inputs.duration
    return single.Assumed(
        branch=stages.upper,
        velocity=_assumed_velocity(h, stages, UPPER),
        load=_held_load(h, stages, UPPER, response.damped),
        limit=h * stages.middle.limit.upper,
        stiffness=-response.coupling[UPPER],
    )


def _pair_motion(
    inputs: Inputs, stages: _Stages, responses: dict[int, Response], mass: Float[Array, "5"]
) -> Assumed:
    """The assumed motion of the lower carriage and the height, likewise."""
    h = inputs.duration
    loads = [_held_load(h, stages, i, responses[i].damped) for i in PAIR]
    return Assumed(
        branch=stages.pair,
        mobility=stages.mobility,
        velocity=tuple(_assumed_velocity(h, stages, i) for i in PAIR),
        load=tuple(
            Quadratic(*(mass[i] * part for part in load))
            for i, load in zip(PAIR, loads, strict=True)
        ),
        damping=tuple(mass[i] * responses[i].damped for i in PAIR),
        stiffness=-mass[LOWER] * responses[LOWER].coupling[LOWER],
    )


def friction_coefficients(robot: Robot) -> Float[Array, "2"]:
    """Kinetic friction of the lower and the upper carriage.

    Args:
        robot: The robot.

    Returns:
        Both coefficients [1].

    Raises:
        TypeError: If a carriage has another friction law than `Coulomb`.
    """
    return jnp.stack([law.coefficient for law in exact_laws(robot)])


def exact_laws(robot: Robot) -> tuple[Coulomb, Coulomb]:
    """The exact friction of the lower and the upper carriage.

    Args:
        robot: The robot.

    Returns:
        Both laws.

    Raises:
        TypeError: If a carriage has another friction law than `Coulomb`.
    """
    for name, carriage in (("lower", robot.lower_carriage), ("upper", robot.upper_carriage)):
        if not isinstance(carriage.friction, Coulomb):
            raise TypeError(
                f"`robot.{name}_carriage.friction` must be `Coulomb` for the fixed-grid "
                f"engine, got `{type(carriage.friction).__name__}`. Use "
                "`scdpr_jax.exact(robot)`, or `scdpr_jax.engines.adaptive` for smooth laws."
            )
    return robot.lower_carriage.friction, robot.upper_carriage.friction
