r"""The fixed-grid engine: exact Coulomb friction, near fourth order, differentiable.

A step covers one interval of zero-order-held voltages. The smooth part is Butcher's
fifth-order Runge-Kutta on the branch that each carriage is on when the step begins. Where
a carriage leaves its branch inside the step (it stops, turns round, sticks or breaks away),
the instant follows in closed form from the step's own polynomials (`scdpr_jax.stick_slip`),
and the friction's deviation acts through the carriage's own response at frozen
coefficients. There is no loop inside a step, so that it vectorises, and derivatives hold
through every event.

A carriage that sticks has a velocity of exactly zero; that is the engine's only memory.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from scdpr_jax.cable import carriage_stiffness, loop_forces
from scdpr_jax.drive import motor_torque
from scdpr_jax.dynamics import State, dampings, masses, smooth_forces
from scdpr_jax.fields import real, si
from scdpr_jax.friction import Coulomb
from scdpr_jax.parameters import Robot
from scdpr_jax.stick_slip import Assumed, Deviation, Quadratic, branch_at_start, deviation

_CARRIAGES = slice(2, 4)
"""The coordinates with friction, $q_3$ and $q_4$."""


class Inputs(eqx.Module):
    """What acts on the robot in the intervals of a time grid, held through each."""

    duration: Float[Array, "..."] = eqx.field(converter=real, metadata=si("s", "h"))
    """Lengths of the intervals [s]; one of length 0 leaves the state as it is."""
    voltage: Float[Array, "... 2"] = eqx.field(converter=real, metadata=si("V", "V"))
    """Commands to the two drives [V]."""
    knock: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "F"))
    """Horizontal force on the end-effector [N]."""


def simulate(robot: Robot, start: State, inputs: Inputs) -> State:
    """Trajectory of the robot on the grid of its inputs.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        start: State at the first instant.
        inputs: Commands and knocks, one row for each of `n` intervals.

    Returns:
        States at the `n + 1` ends of the intervals, the start first.

    Raises:
        TypeError: If a carriage has another friction law.
    """

    def advance(state: State, held: Inputs) -> tuple[State, State]:
        following = step(robot, state, held)
        return following, following

    _, states = jax.lax.scan(advance, start, inputs)
    return jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, states)


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


def step(robot: Robot, state: State, held: Inputs) -> State:
    """The state after one interval.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        state: State at the beginning.
        held: Commands and knock of this one interval.

    Returns:
        State at the end; a carriage that sticks has a velocity of exactly zero.

    Raises:
        TypeError: If a carriage has another friction law.
    """
    stages = _runge_kutta(robot, state, held)
    response = _Response(
        rate=(dampings(robot) / masses(robot))[_CARRIAGES],
        couplings=carriage_stiffness(robot, state.position) / masses(robot)[None, :],
    )
    motions = _assumed_motions(state, held, stages, response)
    return _deviate(held, stages.end, response, jax.vmap(deviation)(motions))


class _Response(NamedTuple):
    """How the robot answers a carriage, at frozen coefficients."""

    rate: Float[Array, "2"]
    """Damping of each carriage over its mass [1/s]."""
    couplings: Float[Array, "2 5"]
    """Restoring acceleration of each coordinate per displacement of a carriage [1/s²]."""


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


class _Stages(NamedTuple):
    """A Runge-Kutta step on the assumed branches: its beginning, middle and end."""

    branch: Float[Array, "2"]
    velocity: tuple[Float[Array, "5"], ...]
    load: tuple[Float[Array, "5"], ...]
    limit: Float[Array, "2"]
    acceleration: tuple[Float[Array, "5"], ...]
    end: State


def _runge_kutta(robot: Robot, state: State, held: Inputs) -> _Stages:
    mass = masses(robot)
    torque = motor_torque(robot.drive, held.voltage)
    coefficients = friction_coefficients(robot)

    def balance(at: State) -> tuple[Float[Array, "5"], Float[Array, "2"]]:
        loop = loop_forces(robot, at.position)
        load = smooth_forces(robot, loop, at.velocity, torque=torque, knock=held.knock)
        return load / mass, coefficients * loop.normal / mass[_CARRIAGES]

    first_load, first_limit = balance(state)
    branch = branch_at_start(state.velocity[_CARRIAGES], first_load[_CARRIAGES], first_limit)

    def accelerate(load: Float[Array, "5"], limit: Float[Array, "2"]) -> Float[Array, "5"]:
        sliding = jnp.where(branch == 0, 0.0, load[_CARRIAGES] - branch * limit)
        return load.at[_CARRIAGES].set(sliding)

    h = held.duration
    at, loads, limits = [state], [first_load], [first_limit]
    slopes = [accelerate(first_load, first_limit)]

    def ahead(weights: tuple[float, ...]) -> State:
        known = [(w, s.velocity, a) for w, s, a in zip(weights, at, slopes, strict=True) if w]
        return State(
            state.position + h * sum(w * velocity for w, velocity, _ in known),
            state.velocity + h * sum(w * slope for w, _, slope in known),
        )

    for weights in _STAGES:
        at.append(ahead(weights))
        load, limit = balance(at[-1])
        loads.append(load)
        limits.append(limit)
        slopes.append(accelerate(load, limit))
    return _Stages(
        branch=branch,
        velocity=tuple(at[i].velocity for i in _PLACES),
        load=tuple(loads[i] for i in _PLACES),
        limit=limits[_PLACES[1]],
        acceleration=tuple(slopes[i] for i in _PLACES),
        end=ahead(_END),
    )


def _assumed_motions(
    state: State, held: Inputs, stages: _Stages, response: _Response
) -> Assumed:
    """The two carriages' assumed motions, as polynomials in the step's time."""
    h = held.duration
    # The load that holds a carriage has no damping in it: a carriage that is held rests.
    first, middle, last = (
        h * (load[_CARRIAGES] + response.rate * velocity[_CARRIAGES])
        for load, velocity in zip(stages.load, stages.velocity, strict=True)
    )
    start, end = state.velocity[_CARRIAGES], stages.end.velocity[_CARRIAGES]
    linear, _, end_slope = (h * slope[_CARRIAGES] for slope in stages.acceleration)
    quadratic = end - start - linear
    return Assumed(
        branch=stages.branch,
        velocity=Quadratic(start, linear, quadratic),
        bend=end_slope - linear - 2 * quadratic,
        load=Quadratic(first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle),
        limit=h * stages.limit,
        stiffness=jnp.square(h) * jnp.diagonal(response.couplings[:, _CARRIAGES]),
    )


def _deviate(held: Inputs, end: State, response: _Response, found: Deviation) -> State:
    """The end of the step under the true friction."""
    h = held.duration
    moved, sped = found.answer(h * response.rate)
    shares = jax.vmap(Deviation.felt)(found, -jnp.square(h) * response.couplings)
    displaced, hastened = (jnp.sum(share, axis=0) for share in shares)
    position = (end.position + h * displaced).at[_CARRIAGES].add(h * moved)
    velocity = (end.velocity + hastened).at[_CARRIAGES].add(sped)
    sliding = jnp.where(found.sticks, 0.0, velocity[_CARRIAGES])
    return State(position, velocity.at[_CARRIAGES].set(sliding))


def friction_coefficients(robot: Robot) -> Float[Array, "2"]:
    """Exact Coulomb friction of the lower and the upper carriage.

    Args:
        robot: The robot.

    Returns:
        Both coefficients [1].

    Raises:
        TypeError: If a carriage has another friction law than `Coulomb`.
    """
    for name, carriage in (("lower", robot.lower_carriage), ("upper", robot.upper_carriage)):
        if not isinstance(carriage.friction, Coulomb):
            raise TypeError(
                f"`robot.{name}_carriage.friction` must be `Coulomb` for the fixed-grid "
                f"engine, got `{type(carriage.friction).__name__}`. Use "
                "`scdpr_jax.exact(robot)`, or `scdpr_jax.simulation` for smooth laws."
            )
    return jnp.stack(
        [robot.lower_carriage.friction.coefficient, robot.upper_carriage.friction.coefficient]
    )
