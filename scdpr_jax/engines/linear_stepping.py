r"""The fixed-grid engine of the linear model: exact between events, for one run or millions.

Near an aligned pose at a height the robot is linear but for its dry friction, Eqs. (18) and
(21) with the drives. On the branches that the contacts begin a step on, a step is a product
with tabulated matrices (`scdpr_jax.engines.propagator`); where a contact leaves its branch,
`scdpr_jax.contacts.stick_slip` and `scdpr_jax.contacts.pulley_stick_slip` say when and by how
much the friction deviates. Near fourth order in the step, by the events alone.

Everything in a step is a scalar: batched by `jax.vmap` these are arrays with the runs side by
side, which a processor works through two to four times as fast as stacked small matrices.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.contacts import stick_slip
from scdpr_jax.contacts.linear_contacts import (
    HEIGHT,
    LOWER,
    UPPER,
    Moving,
    Rubbed,
    Start,
    Tables,
    carriage,
    pulleys,
)
from scdpr_jax.contacts.stick_slip import Scalars
from scdpr_jax.engines.propagator import Propagator, propagator
from scdpr_jax.numerics.lean_scan import lean_scan
from scdpr_jax.numerics.once import once
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import State, drive_forces, masses
from scdpr_jax.robot.parameters import Robot


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


def _unpacked(tables: Propagator) -> Tables:
    def scalars(array: Array | None) -> Array | tuple | None:
        if array is None or not array.ndim:
            return array
        return tuple(scalars(row) for row in array)

    return Tables(*(scalars(getattr(tables, name)) for name in Tables._fields))


def _step(tables: Tables, state: Scalars, held: Scalars) -> Scalars:
    drive, knock, lift = (tables.duration * acceleration for acceleration in held)
    pushed = {LOWER: drive, UPPER: jnp.zeros_like(drive), HEIGHT: lift}
    start = Start(tables, Moving(state[:5], state[5:]), pushed)
    lower = carriage(start, LOWER) if tables.drives is None else pulleys(start)
    contacts = (lower, carriage(start, UPPER))

    rubbed = {i: own for contact in contacts for i, own in contact.rubbed().items()}
    end = _assumed_end(start, rubbed, knock=knock)
    for contact in contacts:
        end = contact.held(end)
    end = Moving(*(tuple(map(once, part)) for part in end))
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


def _response(tables: Tables, i: int) -> stick_slip.Response:
    """How the robot answers a coordinate over a step."""
    if i == HEIGHT:
        couplings = {i: jnp.zeros_like(tables.duration)}
    else:
        couplings = dict(enumerate(tables.coupling[i - LOWER]))
    return stick_slip.Response(tables.damped[i - LOWER], couplings)


def _assumed_end(start: Start, rubbed: dict[int, Rubbed], *, knock: Float[Array, ""]) -> Moving:
    """The step's end on the assumed branches, but for what they hold."""
    tables, (q, v), pushed = start
    steady = {i: once(pushed[i] - own.constant) for i, own in rubbed.items()}
    rising = {i: once(-own.rising) for i, own in rubbed.items()}
    constant, growing = tables.responses
    plane = (*q[:4], *v[:4])
    end = [
        sum(tables.transition[k][j] * plane[j] for j in range(8))
        + sum(
            constant[k][i - LOWER] * steady[i] + growing[k][i - LOWER] * rising[i]
            for i in (LOWER, UPPER)
        )
        + constant[k][2] * knock
        for k in range(8)
    ]
    vertical = (v[HEIGHT], steady.get(HEIGHT, pushed[HEIGHT]), rising.get(HEIGHT))
    y, up = (
        sum(
            part * given for part, given in zip(row, vertical, strict=True) if given is not None
        )
        for row in tables.height
    )
    return Moving((*end[:4], q[HEIGHT] + y), (*end[4:], up))
