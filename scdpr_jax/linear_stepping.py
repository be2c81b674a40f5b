r"""The fixed-grid engine of the linear model: exact between events, for one run or millions.

Near an aligned pose at a height the robot is linear but for its dry friction, Eqs. (18) and
(21) with the drives. On the branches that the contacts begin a step on, a step is a product
with tabulated matrices (`scdpr_jax.propagator`); where a contact leaves its branch,
`scdpr_jax.stick_slip` and `scdpr_jax.pulley_stick_slip` say when and by how much the friction
deviates. Near fourth order in the step, by the events alone.

Everything in a step is a scalar: batched by `jax.vmap` these are arrays with the runs side by
side, which a processor works through two to four times as fast as stacked small matrices.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax import pulley_stick_slip, stick_slip
from scdpr_jax.drive import motor_torque
from scdpr_jax.dynamics import State, drive_forces, masses
from scdpr_jax.lean_scan import lean_scan
from scdpr_jax.once import once
from scdpr_jax.parameters import Robot
from scdpr_jax.propagator import Propagator, propagator
from scdpr_jax.pulley_stick_slip import Pair
from scdpr_jax.stick_slip import Quadratic, Scalars

_LOWER, _UPPER, _HEIGHT = 2, 3, 4
"""The coordinates with friction, $q_3$, $q_4$ and $y_e$."""
_PAIR = (_LOWER, _HEIGHT)
"""Those that share the lower carriage's and the drives' friction."""


def simulate_linear(
    robot: Robot,
    start: State,
    *,
    height: Float[Array, ""],
    interval: Float[Array, ""],
    voltage: Float[Array, "n 2"],
    knock: Float[Array, " n"] | None = None,
    substeps: int = 1,
    rubbing_drives: bool = True,
) -> State:
    """Trajectory of the linear robot with exact Coulomb friction, on an even grid.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages, whose rise near standstill
            has no part in the linear model.
        start: State at the first instant.
        height: Height of the end-effector about which the robot is linear [m].
        interval: Length of the intervals in which the inputs are held [s], above zero.
        voltage: Commands to the two drives in the `n` intervals [V].
        knock: Horizontal force on the end-effector in the intervals [N]; `None` for none.
        substeps: Steps in an interval; the error falls with their third power.
        rubbing_drives: Whether the drives' dry friction is followed. Where they have none, a
            run without it is the same and takes less than half the time.

    Returns:
        States at the `n + 1` ends of the intervals, the start first.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If `substeps` is below 1.
    """
    if substeps < 1:
        raise ValueError(
            f"`substeps` must be 1 or more [steps in an interval], got {substeps}. Take 1 for "
            "inputs every 5 ms, 5 for inputs every 25 ms."
        )
    tables = _unpacked(
        propagator(
            robot, height=height, duration=interval / substeps, rubbing_drives=rubbing_drives
        )
    )
    pushes = _accelerations(robot, voltage, knock)

    def advance(state: Scalars, held: Scalars) -> tuple[Scalars, Scalars]:
        state = jax.lax.fori_loop(0, substeps, lambda _, now: _step(tables, now, held), state)
        return state, state

    first = (*start.position, *start.velocity)
    _, rows = lean_scan(advance, first, pushes)
    columns = [jnp.concatenate([a[None], b]) for a, b in zip(first, rows, strict=True)]
    return State(jnp.stack(columns[:5], axis=-1), jnp.stack(columns[5:], axis=-1))


def linear_step(
    robot: Robot,
    tables: Propagator,
    state: State,
    *,
    voltage: Float[Array, "2"],
    knock: Float[Array, ""],
) -> State:
    """The state after one tabulated step.

    Args:
        robot: The robot that the tables were made for.
        tables: The tabulated step.
        state: State at the beginning.
        voltage: Commands to the two drives, held through the step [V].
        knock: Horizontal force on the end-effector, held through the step [N].

    Returns:
        State at the end; what sticks has a velocity, or a pulley's rate, of exactly zero.
    """
    held = tuple(push[0] for push in _accelerations(robot, voltage[None], knock[None]))
    found = _step(_unpacked(tables), (*state.position, *state.velocity), held)
    return State(jnp.stack(found[:5]), jnp.stack(found[5:]))


def _accelerations(
    robot: Robot, voltage: Float[Array, "n 2"], knock: Float[Array, " n"] | None
) -> tuple[Float[Array, " n"], ...]:
    """What the inputs do to the lower carriage, the end-effector and the height [m/s²]."""
    mass = masses(robot)
    torque = motor_torque(robot.drive, voltage)
    forces = jax.vmap(drive_forces, in_axes=(None, 0))(robot, torque)
    knock = jnp.zeros_like(voltage[:, 0]) if knock is None else knock
    weight = robot.gravity * robot.end_effector.mass
    return forces[:, 2] / mass[2], knock / mass[0], (forces[:, 4] - weight) / mass[4]


class _Tables(NamedTuple):
    """A propagator's tables as scalars, unpacked once: batched, each is an array of its own."""

    duration: Float[Array, ""]
    transition: tuple[Scalars, ...]
    responses: tuple[tuple[Scalars, ...], ...]
    pull: tuple[Scalars, ...]
    coupling: tuple[Scalars, ...]
    mass: Scalars
    damped: Scalars
    limit: Scalars
    height: tuple[Scalars, ...]
    drives: Scalars | None


def _unpacked(tables: Propagator) -> _Tables:
    def scalars(array: Array | None) -> Array | tuple | None:
        if array is None or not array.ndim:
            return array
        return tuple(scalars(row) for row in array)

    return _Tables(*(scalars(getattr(tables, name)) for name in _Tables._fields))


class _Moving(NamedTuple):
    r"""A state as scalars: $[x_e, \delta_e, q_3, q_4, y_e]$ and its derivative."""

    position: Scalars
    velocity: Scalars


class _Start(NamedTuple):
    """A step's beginning and what is held through it."""

    tables: _Tables
    state: _Moving
    pushed: dict[int, Float[Array, ""]]
    """What drives and weight do to the coordinates with friction in the step [m/s]."""

    def load(self, i: int, at: _Moving) -> Float[Array, ""]:
        """What acts on a coordinate in the step but damping and dry friction [m/s]."""
        return self._pulled(i, at.position) + self.pushed[i]

    def load_slope(self, i: int) -> Float[Array, ""]:
        """How that changes at the beginning [m/s]."""
        return self.tables.duration * self._pulled(i, self.state.velocity)

    def _pulled(self, i: int, along: Scalars) -> Float[Array, ""]:
        if i == _HEIGHT:
            return jnp.zeros_like(along[i])
        row = self.tables.pull[i - _LOWER]
        return sum(row[j] * along[j] for j in range(4))


class _Rubbed(NamedTuple):
    """Assumed friction on a coordinate through the step, in velocity units [m/s].

    It is constant on what slides; on what is held it is the load, but for its curvature,
    which is known only at the step's end.
    """

    constant: Float[Array, ""]
    rising: Float[Array, ""]


class _Departure(NamedTuple):
    """How contacts leave the branches that they begin a step on."""

    deviations: dict[int, stick_slip.Deviation]
    """By the coordinate that feels them."""
    at_rest: Callable[[Sequence[Float[Array, ""]]], dict[int, Float[Array, ""]]]
    """From velocities at the end to those by which what sticks is at rest to the bit."""


def _step(tables: _Tables, state: Scalars, held: Scalars) -> Scalars:
    drive, knock, lift = (tables.duration * acceleration for acceleration in held)
    pushed = {_LOWER: drive, _UPPER: jnp.zeros_like(drive), _HEIGHT: lift}
    start = _Start(tables, _Moving(state[:5], state[5:]), pushed)
    lower = _carriage(start, _LOWER) if tables.drives is None else _pulleys(start)
    contacts = (lower, _carriage(start, _UPPER))

    rubbed = {i: own for contact in contacts for i, own in contact.rubbed().items()}
    end = _assumed_end(start, rubbed, knock=knock)
    for contact in contacts:
        end = contact.held(end)
    end = _Moving(*(tuple(map(once, part)) for part in end))
    departures = [contact.departure(end) for contact in contacts]
    deviations = {i: own for departure in departures for i, own in departure.deviations.items()}
    position, velocity = stick_slip.deviated(
        *end,
        duration=tables.duration,
        deviations=deviations,
        responses={i: _response(tables, i) for i in deviations},
    )
    for departure in departures:
        for i, speed in departure.at_rest(velocity).items():
            velocity[i] = speed
    return (*position, *velocity)


def _response(tables: _Tables, i: int) -> stick_slip.Response:
    """How the robot answers a coordinate over a step."""
    if i == _HEIGHT:
        couplings = {i: jnp.zeros_like(tables.duration)}
    else:
        couplings = dict(enumerate(tables.coupling[i - _LOWER]))
    return stick_slip.Response(tables.damped[i - _LOWER], couplings)


def _assumed_end(
    start: _Start, rubbed: dict[int, _Rubbed], *, knock: Float[Array, ""]
) -> _Moving:
    """The step's end on the assumed branches, but for what they hold."""
    tables, (q, v), pushed = start
    steady = {i: once(pushed[i] - own.constant) for i, own in rubbed.items()}
    rising = {i: once(-own.rising) for i, own in rubbed.items()}
    constant, growing = tables.responses
    plane = (*q[:4], *v[:4])
    end = [
        sum(tables.transition[k][j] * plane[j] for j in range(8))
        + sum(
            constant[k][i - _LOWER] * steady[i] + growing[k][i - _LOWER] * rising[i]
            for i in (_LOWER, _UPPER)
        )
        + constant[k][2] * knock
        for k in range(8)
    ]
    vertical = (v[_HEIGHT], steady.get(_HEIGHT, pushed[_HEIGHT]), rising.get(_HEIGHT))
    y, up = (
        sum(
            part * given for part, given in zip(row, vertical, strict=True) if given is not None
        )
        for row in tables.height
    )
    return _Moving((*end[:4], q[_HEIGHT] + y), (*end[4:], up))


class _Carriage(NamedTuple):
    """A carriage under its own friction alone, on the branch that it begins a step on."""

    start: _Start
    i: int
    damped: Float[Array, ""]
    limit: Float[Array, ""]
    branch: Float[Array, ""]
    load: Float[Array, ""]
    slope: Float[Array, ""]

    def rubbed(self) -> dict[int, _Rubbed]:
        """Its assumed friction."""
        rests = self.branch == 0
        steady = jnp.where(rests, self.load, self.branch * self.limit)
        return {self.i: _Rubbed(steady, jnp.where(rests, self.slope, 0.0))}

    def held(self, end: _Moving) -> _Moving:
        """The assumed end with what the branch holds put back."""
        q, v = list(end.position), list(end.velocity)
        rests = self.branch == 0
        q[self.i] = jnp.where(rests, self.start.state.position[self.i], q[self.i])
        v[self.i] = jnp.where(rests, 0.0, v[self.i])
        return _Moving(tuple(q), tuple(v))

    def departure(self, end: _Moving) -> _Departure:
        """Where it leaves its branch, by its motion and load as polynomials."""
        i, speed, arriving = self.i, self.start.state.velocity[self.i], end.velocity[self.i]
        rests, friction = self.branch == 0, self.branch * self.limit
        linear = jnp.where(rests, 0.0, self.load - self.damped * speed - friction)
        quadratic = arriving - speed - linear
        last = self.start.load(i, end)
        curve = once(last - self.load - self.slope)
        end_slope = last - self.damped * arriving - friction
        found = stick_slip.deviation(
            stick_slip.Assumed(
                branch=self.branch,
                velocity=Quadratic(speed, linear, quadratic),
                bend=end_slope - linear - 2 * quadratic,
                load=Quadratic(self.load, self.slope, curve),
                limit=self.limit,
                unheld=jnp.where(rests, curve, 0.0),
                stiffness=_stiffness(self.start.tables, i),
            )
        )
        return _Departure(
            {i: found}, lambda velocity: {i: jnp.where(found.sticks, 0.0, velocity[i])}
        )


def _carriage(start: _Start, i: int) -> _Carriage:
    """The carriage of this coordinate as a step begins."""
    damped, limit = start.tables.damped[i - _LOWER], start.tables.limit[i - _LOWER]
    load = start.load(i, start.state)
    branch = stick_slip.branch_at_start(start.state.velocity[i], load, limit)
    return _Carriage(start, i, damped, limit, branch, load, start.load_slope(i))


def _stiffness(tables: _Tables, i: int) -> Float[Array, ""]:
    """The cables' stiffness against a carriage, times the step squared over mass [1]."""
    return -tables.duration * tables.pull[i - _LOWER][i]


class _Pulleys(NamedTuple):
    """Lower carriage and height under the friction of the guide and of both drives."""

    start: _Start
    contacts: pulley_stick_slip.Contacts
    damping: Pair
    """Viscous damping, times the step's length [kg]."""
    branch: pulley_stick_slip.Branch
    mobility: pulley_stick_slip.Three
    load: Pair
    """As the step begins, without damping [N s]."""
    slope: Pair
    """How it changes then [N s]."""
    gain: Pair
    """What is gained in a step at the beginning's acceleration [m/s]."""

    def rubbed(self) -> dict[int, _Rubbed]:
        """Their assumed friction."""
        force = _less(self.load, self.damping, self._speeds(self.start.state))
        slope = _less(self.slope, self.damping, self.gain)
        turn = pulley_stick_slip.act(self.mobility, slope)
        return {
            i: _Rubbed(force[n] / m - self.gain[n], slope[n] / m - turn[n])
            for n, (i, m) in enumerate(zip(_PAIR, self.contacts.mass, strict=True))
        }

    def held(self, end: _Moving) -> _Moving:
        """The assumed end with what the branch holds put back."""
        q, v = list(end.position), list(end.velocity)
        before = self.start.state.position
        moved = self.branch.exactly(tuple(q[i] - before[i] for i in _PAIR), self.contacts.mass)
        speeds = self.branch.exactly(self._speeds(end), self.contacts.mass)
        for i, way, speed in zip(_PAIR, moved, speeds, strict=True):
            q[i], v[i] = before[i] + way, speed
        return _Moving(tuple(q), tuple(v))

    def departure(self, end: _Moving) -> _Departure:
        """Where they leave their branch, by their motion and load as polynomials."""
        mass = self.contacts.mass
        speeds, arriving = self._speeds(self.start.state), self._speeds(end)
        last = tuple(m * self.start.load(i, end) for i, m in zip(_PAIR, mass, strict=True))
        end_gain = _gain(
            self.branch, self.mobility, _less(last, self.damping, arriving), self.contacts
        )
        quadratic = tuple(
            b - a - g for a, b, g in zip(speeds, arriving, self.gain, strict=True)
        )
        curve = tuple(
            once(b - a - s) for a, b, s in zip(self.load, last, self.slope, strict=True)
        )
        found = pulley_stick_slip.deviation(
            pulley_stick_slip.Assumed(
                branch=self.branch,
                mobility=self.mobility,
                velocity=_quadratics(speeds, self.gain, quadratic),
                bend=tuple(
                    e - g - 2 * c
                    for e, g, c in zip(end_gain, self.gain, quadratic, strict=True)
                ),
                load=_quadratics(self.load, self.slope, curve),
                damping=self.damping,
                stiffness=mass[0] * _stiffness(self.start.tables, _LOWER),
            ),
            self.contacts,
        )
        unheld = ((1 / mass[0] - self.mobility[0]) * curve[0], jnp.zeros_like(curve[1]))
        deviations = {
            i: stick_slip.deviating(moments, unheld[n], sticks=found.branch.origin != 0)
            for n, (i, moments) in enumerate(
                zip(_PAIR, zip(*found.moments, strict=True), strict=True)
            )
        }

        def at_rest(velocity: Sequence[Float[Array, ""]]) -> dict[int, Float[Array, ""]]:
            pair = tuple(velocity[i] for i in _PAIR)
            return dict(zip(_PAIR, found.branch.exactly(pair, mass), strict=True))

        return _Departure(deviations, at_rest)

    def _speeds(self, at: _Moving) -> Pair:
        return tuple(at.velocity[i] for i in _PAIR)


def _pulleys(start: _Start) -> _Pulleys:
    """Lower carriage and height as a step begins."""
    tables, (_, velocity) = start.tables, start.state
    mass = tuple(tables.mass[i - _LOWER] for i in _PAIR)
    damping = tuple(m * tables.damped[i - _LOWER] for i, m in zip(_PAIR, mass, strict=True))
    contacts = pulley_stick_slip.Contacts(mass, (*tables.drives, tables.limit[0] * mass[0]))
    load = tuple(m * start.load(i, start.state) for i, m in zip(_PAIR, mass, strict=True))
    slope = tuple(m * start.load_slope(i) for i, m in zip(_PAIR, mass, strict=True))
    speeds = tuple(velocity[i] for i in _PAIR)
    force = _less(load, damping, speeds)
    branch = pulley_stick_slip.branch_at_start(speeds, force, contacts)
    mobility = branch.mobility(mass)
    gain = tuple(map(once, _gain(branch, mobility, force, contacts)))
    return _Pulleys(start, contacts, damping, branch, mobility, load, slope, gain)


def _gain(
    branch: pulley_stick_slip.Branch,
    mobility: pulley_stick_slip.Three,
    force: Pair,
    contacts: pulley_stick_slip.Contacts,
) -> Pair:
    """What a branch gains in a step under a force, damping included [m/s]."""
    slide = branch.friction(contacts.limit)
    return pulley_stick_slip.act(
        mobility, tuple(p - f for p, f in zip(force, slide, strict=True))
    )


def _less(load: Pair, damping: Pair, velocity: Pair) -> Pair:
    """A load less what damping takes of it."""
    return tuple(p - c * v for p, c, v in zip(load, damping, velocity, strict=True))


def _quadratics(constant: Pair, linear: Pair, quadratic: Pair) -> tuple[Quadratic, Quadratic]:
    return tuple(map(Quadratic, constant, linear, quadratic))
