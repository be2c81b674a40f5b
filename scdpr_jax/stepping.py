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

from collections.abc import Sequence
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
from scdpr_jax.lean_scan import lean_scan
from scdpr_jax.once import once
from scdpr_jax.parameters import Robot
from scdpr_jax.stick_slip import Assumed, Deviation, Quadratic, branch_at_start, deviation

_CARRIAGES = (2, 3)
"""The coordinates with friction, $q_3$ and $q_4$."""

_Five = tuple[Float[Array, ""], ...]
"""A scalar for each of the five coordinates."""


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

    _, states = lean_scan(advance, start, inputs)
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
    start = _Moving(*(tuple(jnp.unstack(part)) for part in (state.position, state.velocity)))
    stages = _runge_kutta(robot, start, held)
    mass = jnp.unstack(masses(robot))
    stiffness = carriage_stiffness(robot, state.position)
    carriages = [
        _Carriage(
            index=index,
            rate=damping / mass[index],
            couplings=tuple(k / m for k, m in zip(jnp.unstack(row), mass, strict=True)),
        )
        for index, damping, row in zip(
            _CARRIAGES, jnp.unstack(dampings(robot))[2:4], jnp.unstack(stiffness), strict=True
        )
    ]
    found = [deviation(_assumed_motion(held, stages, carriage)) for carriage in carriages]
    return _deviate(held, stages.end, carriages, found)


class _Carriage(NamedTuple):
    """A carriage and how the robot answers it, at frozen coefficients."""

    index: int
    """Its place among the coordinates."""
    rate: Float[Array, ""]
    """Damping over its mass [1/s]."""
    couplings: _Five
    """Restoring acceleration of each coordinate per displacement of it [1/s²]."""


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


class _Moving(NamedTuple):
    """A state as scalars: batched, each is an array of its own."""

    position: _Five
    velocity: _Five


class _Stage(NamedTuple):
    """A stage of a Runge-Kutta step, with what acts over the masses [m/s², rad/s²]."""

    at: _Moving
    load: _Five
    """All but the carriages' friction."""
    limit: tuple[Float[Array, ""], ...]
    """Largest friction of the lower and of the upper carriage."""
    slope: _Five
    """Acceleration on the branches."""


class _Stages(NamedTuple):
    """A Runge-Kutta step on the branches that it began on."""

    branch: tuple[Float[Array, ""], ...]
    """Branch of the lower and of the upper carriage."""
    beginning: _Stage
    middle: _Stage
    last: _Stage
    end: _Moving


def _runge_kutta(robot: Robot, start: _Moving, held: Inputs) -> _Stages:
    mass = jnp.unstack(masses(robot))
    torque = motor_torque(robot.drive, held.voltage)
    laws = exact_laws(robot)

    def balance(at: _Moving) -> tuple[_Five, tuple[Float[Array, ""], ...]]:
        loop = loop_forces(robot, jnp.stack(at.position))
        force = smooth_forces(
            robot, loop, jnp.stack(at.velocity), torque=torque, knock=held.knock
        )
        load = tuple(once(f / m) for f, m in zip(jnp.unstack(force), mass, strict=True))
        normal = zip(laws, at.velocity[2:4], jnp.unstack(loop.normal), mass[2:4], strict=True)
        return load, tuple(once(law.sliding(v) * n / m) for law, v, n, m in normal)

    load, limit = balance(start)
    branch = tuple(
        branch_at_start(start.velocity[i], load[i], own)
        for i, own in zip(_CARRIAGES, limit, strict=True)
    )

    def stage(at: _Moving, load: _Five, limit: tuple[Float[Array, ""], ...]) -> _Stage:
        sliding = [
            jnp.where(side == 0, 0.0, load[i] - side * own)
            for i, side, own in zip(_CARRIAGES, branch, limit, strict=True)
        ]
        return _Stage(at, load, limit, (*load[:2], *sliding, load[4]))

    def ahead(weights: tuple[float, ...]) -> _Moving:
        parts = [(held.duration * w, s) for w, s in zip(weights, stages, strict=True) if w]
        return _Moving(
            tuple(
                once(q + sum(w * s.at.velocity[i] for w, s in parts))
                for i, q in enumerate(start.position)
            ),
            tuple(
                once(v + sum(w * s.slope[i] for w, s in parts))
                for i, v in enumerate(start.velocity)
            ),
        )

    stages = [stage(start, load, limit)]
    for weights in _STAGES:
        at = ahead(weights)
        stages.append(stage(at, *balance(at)))
    return _Stages(branch, *(stages[i] for i in _PLACES), end=ahead(_END))


def _assumed_motion(held: Inputs, stages: _Stages, carriage: _Carriage) -> Assumed:
    """A carriage's assumed motion, as polynomials in the step's time."""
    h, i = held.duration, carriage.index
    three = (stages.beginning, stages.middle, stages.last)
    # The load that holds a carriage has no damping in it: a carriage that is held rests.
    first, middle, last = (
        h * (stage.load[i] + carriage.rate * stage.at.velocity[i]) for stage in three
    )
    start, end = stages.beginning.at.velocity[i], stages.end.velocity[i]
    linear, end_slope = h * stages.beginning.slope[i], h * stages.last.slope[i]
    quadratic = end - start - linear
    return Assumed(
        branch=stages.branch[_CARRIAGES.index(i)],
        velocity=Quadratic(start, linear, quadratic),
        bend=end_slope - linear - 2 * quadratic,
        load=Quadratic(first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle),
        limit=h * stages.middle.limit[_CARRIAGES.index(i)],
        # The stages hold it where it is.
        unheld=jnp.zeros_like(h),
        stiffness=jnp.square(h) * carriage.couplings[i],
    )


def _deviate(
    held: Inputs, end: _Moving, carriages: Sequence[_Carriage], found: Sequence[Deviation]
) -> State:
    """The end of the step under the true friction."""
    h = held.duration
    position, velocity = list(end.position), list(end.velocity)
    for carriage, own in zip(carriages, found, strict=True):
        for k, stiffness in enumerate(carriage.couplings):
            coupling = -jnp.square(h) * stiffness
            itself = k == carriage.index
            moved, sped = (
                own.answer(h * carriage.rate, coupling) if itself else own.felt(coupling)
            )
            position[k] += h * moved
            velocity[k] += sped
    for carriage, own in zip(carriages, found, strict=True):
        i = carriage.index
        velocity[i] = jnp.where(own.sticks, 0.0, velocity[i])
    return State(jnp.stack(position), jnp.stack(velocity))


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
                "`scdpr_jax.exact(robot)`, or `scdpr_jax.simulation` for smooth laws."
            )
    return robot.lower_carriage.friction, robot.upper_carriage.friction
