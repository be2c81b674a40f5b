r"""The fixed-grid engine: exact Coulomb friction, near fourth order, differentiable.

A step covers one interval of zero-order-held voltages. The smooth part is Butcher's
fifth-order Runge-Kutta on the branches that the contacts are on when the step begins. Where
one leaves its branch inside the step (it stops, turns round, sticks or breaks away), the
instant follows in closed form from the step's own polynomials, and the friction's deviation
acts through the robot's own response at frozen coefficients. The upper carriage has its
friction to itself (`scdpr_jax.contacts.stick_slip`); the lower carriage and both drives share
the pair $(\dot q_3, \dot y_e)$ (`scdpr_jax.contacts.pulley_stick_slip`). There is no loop
inside a step, so that it vectorises, and derivatives hold through every event.

A carriage that sticks has a velocity of exactly zero, a drive that sticks has
$\dot q_3 = \mp\dot y_e$ exactly; that is the engine's only memory.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from scdpr_jax.contacts import pulley_stick_slip, stick_slip
from scdpr_jax.contacts.stick_slip import Quadratic, Scalars
from scdpr_jax.numerics.lean_scan import lean_scan
from scdpr_jax.numerics.once import once
from scdpr_jax.robot.cable import carriage_stiffness, loop_forces
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import State, dampings, masses, smooth_forces
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import Robot

_LOWER, _UPPER, _HEIGHT = 2, 3, 4
"""The coordinates with friction, $q_3$, $q_4$ and $y_e$."""
_PAIR = (_LOWER, _HEIGHT)
"""Those that share the lower carriage's and the drives' friction."""


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
        State at the end; what sticks has a velocity, or a pulley's rate, of exactly zero.

    Raises:
        TypeError: If a carriage has another friction law.
    """
    start = _Moving(*(tuple(jnp.unstack(part)) for part in (state.position, state.velocity)))
    stages = _runge_kutta(robot, start, held)
    responses = _responses(robot, state, held)
    mass = tuple(jnp.unstack(masses(robot)))
    upper = stick_slip.deviation(_upper_motion(held, stages, responses[_UPPER]))
    contacts = pulley_stick_slip.Contacts(
        tuple(mass[i] for i in _PAIR),
        tuple(held.duration * limit for limit in stages.middle.limit.pair),
    )
    pair = pulley_stick_slip.deviation(_pair_motion(held, stages, responses, mass), contacts)
    return _deviated(held, stages.end, responses, upper, pair, contacts)


def _responses(robot: Robot, state: State, held: Inputs) -> dict[int, stick_slip.Response]:
    """How the robot answers coordinates with friction, at frozen coefficients."""
    h, mass = held.duration, jnp.unstack(masses(robot))
    damping = jnp.unstack(dampings(robot))
    rows = jnp.unstack(carriage_stiffness(robot, state.position))
    couplings = {
        i: {k: -jnp.square(h) * own / mass[k] for k, own in enumerate(jnp.unstack(row))}
        for i, row in zip((_LOWER, _UPPER), rows, strict=True)
    }
    # The height's stiffness is of second order in the inclinations.
    couplings[_HEIGHT] = {_HEIGHT: jnp.zeros_like(mass[_HEIGHT])}
    return {
        i: stick_slip.Response(h * damping[i] / mass[i], own) for i, own in couplings.items()
    }


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

    position: Scalars
    velocity: Scalars


class _Limits(NamedTuple):
    """Largest frictions at a position."""

    upper: Float[Array, ""]
    """Of the upper carriage, over its mass [m/s²]."""
    pair: pulley_stick_slip.Three
    """Of both drives at their pulleys' rims, and of the lower carriage [N]."""


class _Stage(NamedTuple):
    """A stage of a Runge-Kutta step, with what acts over the masses [m/s², rad/s²]."""

    at: _Moving
    load: Scalars
    """All but dry friction."""
    limit: _Limits
    slope: Scalars
    """Acceleration on the branches."""


class _Stages(NamedTuple):
    """A Runge-Kutta step on the branches that it began on."""

    upper: Float[Array, ""]
    """Branch of the upper carriage."""
    pair: pulley_stick_slip.Branch
    """Branch of the lower carriage and the drives."""
    mobility: pulley_stick_slip.Three
    """That branch's [1/kg]."""
    beginning: _Stage
    middle: _Stage
    last: _Stage
    end: _Moving

    @property
    def three(self) -> tuple[_Stage, _Stage, _Stage]:
        """The stages at the beginning, in the middle and at the end of the step."""
        return self.beginning, self.middle, self.last


def _runge_kutta(robot: Robot, start: _Moving, held: Inputs) -> _Stages:
    mass = jnp.unstack(masses(robot))
    pair_mass = tuple(mass[i] for i in _PAIR)
    torque = motor_torque(robot.drive, held.voltage)
    lower, upper = exact_laws(robot)
    drives = tuple(jnp.unstack(robot.drive.frictions / robot.drive.effective_radius))

    def balance(at: _Moving) -> tuple[Scalars, _Limits]:
        loop = loop_forces(robot, jnp.stack(at.position))
        force = smooth_forces(
            robot, loop, jnp.stack(at.velocity), torque=torque, knock=held.knock
        )
        load = tuple(once(f / m) for f, m in zip(jnp.unstack(force), mass, strict=True))
        on_lower, on_upper = jnp.unstack(loop.normal)
        guide = once(lower.sliding(at.velocity[_PAIR[0]]) * on_lower)
        own = once(upper.sliding(at.velocity[_UPPER]) * on_upper / mass[_UPPER])
        return load, _Limits(own, (*drives, guide))

    def on_pair(load: Scalars) -> pulley_stick_slip.Pair:
        return tuple(load[i] * mass[i] for i in _PAIR)

    load, limit = balance(start)
    branch = stick_slip.branch_at_start(start.velocity[_UPPER], load[_UPPER], limit.upper)
    pair = pulley_stick_slip.branch_at_start(
        tuple(start.velocity[i] for i in _PAIR),
        on_pair(load),
        pulley_stick_slip.Contacts(pair_mass, limit.pair),
    )
    mobility = pair.mobility(pair_mass)

    def stage(at: _Moving, load: Scalars, limit: _Limits) -> _Stage:
        free = jnp.where(branch == 0, 0.0, load[_UPPER] - branch * limit.upper)
        rubbed = pair.friction(limit.pair)
        driving = tuple(p - f for p, f in zip(on_pair(load), rubbed, strict=True))
        along, up = pulley_stick_slip.act(mobility, driving)
        return _Stage(at, load, limit, (*load[:2], along, free, up))

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
    return _Stages(branch, pair, mobility, *(stages[i] for i in _PLACES), end=ahead(_END))


def _assumed_velocity(h: Float[Array, ""], stages: _Stages, i: int) -> tuple[Quadratic, Array]:
    """A coordinate's velocity through the step, and the bend that makes it a cubic."""
    start, end = stages.beginning.at.velocity[i], stages.end.velocity[i]
    linear, end_slope = h * stages.beginning.slope[i], h * stages.last.slope[i]
    quadratic = end - start - linear
    return Quadratic(start, linear, quadratic), end_slope - linear - 2 * quadratic


def _held_load(
    h: Float[Array, ""], stages: _Stages, i: int, damped: Float[Array, ""]
) -> Quadratic:
    """What friction must balance to hold a coordinate: no damping, as what is held rests."""
    first, middle, last = (
        h * stage.load[i] + damped * stage.at.velocity[i] for stage in stages.three
    )
    return Quadratic(first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle)


def _upper_motion(
    held: Inputs, stages: _Stages, response: stick_slip.Response
) -> stick_slip.Assumed:
    """The upper carriage's assumed motion, as polynomials in the step's time."""
    h = held.duration
    velocity, bend = _assumed_velocity(h, stages, _UPPER)
    return stick_slip.Assumed(
        branch=stages.upper,
        velocity=velocity,
        bend=bend,
        load=_held_load(h, stages, _UPPER, response.damped),
        limit=h * stages.middle.limit.upper,
        # The stages hold it where it is.
        unheld=jnp.zeros_like(h),
        stiffness=-response.couplings[_UPPER],
    )


def _pair_motion(
    held: Inputs, stages: _Stages, responses: dict[int, stick_slip.Response], mass: Scalars
) -> pulley_stick_slip.Assumed:
    """The assumed motion of the lower carriage and the height, likewise."""
    h = held.duration
    velocities, bends = zip(*(_assumed_velocity(h, stages, i) for i in _PAIR), strict=True)
    loads = [_held_load(h, stages, i, responses[i].damped) for i in _PAIR]
    return pulley_stick_slip.Assumed(
        branch=stages.pair,
        mobility=stages.mobility,
        velocity=velocities,
        bend=bends,
        load=tuple(
            Quadratic(*(mass[i] * part for part in load))
            for i, load in zip(_PAIR, loads, strict=True)
        ),
        damping=tuple(mass[i] * responses[i].damped for i in _PAIR),
        stiffness=-mass[_LOWER] * responses[_LOWER].couplings[_LOWER],
    )


def _deviated(
    held: Inputs,
    end: _Moving,
    responses: dict[int, stick_slip.Response],
    upper: stick_slip.Deviation,
    pair: pulley_stick_slip.Deviation,
    contacts: pulley_stick_slip.Contacts,
) -> State:
    """The end of the step under the true friction."""
    deviations = {_UPPER: upper}
    for i, moments in zip(_PAIR, zip(*pair.moments, strict=True), strict=True):
        deviations[i] = stick_slip.Deviation(moments, moments[2:], pair.branch.origin != 0)
    position, velocity = stick_slip.deviated(
        *end, duration=held.duration, deviations=deviations, responses=responses
    )
    velocity[_UPPER] = jnp.where(upper.sticks, 0.0, velocity[_UPPER])
    lower, height = pair.branch.exactly(tuple(velocity[i] for i in _PAIR), contacts.mass)
    velocity[_PAIR[0]], velocity[_PAIR[1]] = lower, height
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
                "`scdpr_jax.exact(robot)`, or `scdpr_jax.engines.adaptive` for smooth laws."
            )
    return robot.lower_carriage.friction, robot.upper_carriage.friction
