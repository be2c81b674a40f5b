r"""The fixed-grid engine of the linear model: exact between events, for one run or millions.

Near an aligned pose at a height the robot is linear but for its dry friction, Eqs. (18) and
(21) with the drives. On the branches that the carriages begin a step on, a step is a product
with tabulated matrices; where a carriage leaves its branch, `scdpr_jax.stick_slip` says when
and by how much the friction deviates. Near fourth order in the step, by the events alone.
The model has no dry friction in the drives: `scdpr_jax.stepping` has it.

Everything in a step is a scalar: batched by `jax.vmap` these are arrays with the runs side by
side, which a processor works through two to four times as fast as stacked small matrices.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.drive import motor_torque
from scdpr_jax.dynamics import State, dampings, drive_forces, masses
from scdpr_jax.fields import real, si
from scdpr_jax.lean_scan import lean_scan
from scdpr_jax.linear import linearise
from scdpr_jax.once import once
from scdpr_jax.parameters import Robot
from scdpr_jax.stepping import friction_coefficients
from scdpr_jax.stick_slip import Assumed, Quadratic, branch_at_start, deviation

_PLANE = (0, 1, 2, 3, 5, 6, 7, 8)
"""Rows of the state space that belong to $[x_e, \\delta_e, q_3, q_4]$ and its derivative."""
_TERMS, _DOUBLINGS = 12, 3
"""Taylor terms of the tables, and how often these are doubled: accurate to rounding while a
step takes less than a third of the fastest period."""

Scalars = tuple[Float[Array, ""], ...]


class Propagator(eqx.Module):
    r"""A step of the linear robot, tabulated once for a robot, a height and a length."""

    duration: Float[Array, ""] = eqx.field(converter=real, metadata=si("s", "h"))
    """Length of the step [s]."""
    transition: Float[Array, "8 8"] = eqx.field(converter=real, metadata=si("SI", r"\Phi"))
    r"""$e^{hA}$ on $[x_e, \delta_e, q_3, q_4]$ and its derivative [SI, row over column]."""
    responses: Float[Array, "2 8 3"] = eqx.field(converter=real, metadata=si("SI", "G_k"))
    r"""$\varphi_{k+1}(hA)\,b$: answers to an acceleration of 1 m/s a step, constant or grown to
    from zero, of the lower carriage, the upper one and the end-effector [SI, 1 for a speed]."""
    pull: Float[Array, "2 4"] = eqx.field(converter=real, metadata=si("1/s", "-hK/m"))
    """What a displacement of each coordinate does to both carriages in a step [1/s]."""
    coupling: Float[Array, "2 4"] = eqx.field(converter=real, metadata=si("1", "-h^2 K/m"))
    """Acceleration of each coordinate per displacement of both carriages, times the step's
    length squared [1]."""
    damped: Float[Array, "2"] = eqx.field(converter=real, metadata=si("1", "hd/m"))
    """Share of the speed of both carriages that damping takes in a step [1]."""
    limit: Float[Array, "2"] = eqx.field(converter=real, metadata=si("m/s", r"4hT\mu/m"))
    """Largest change of speed of both carriages by friction in a step [m/s]."""
    height_transition: Float[Array, "2 2"] = eqx.field(
        converter=real, metadata=si("SI", r"\Phi_y")
    )
    """The step of height and vertical speed: from the speed, and from an acceleration."""


def propagator(
    robot: Robot, *, height: Float[Array, ""], duration: Float[Array, ""]
) -> Propagator:
    """The step of the robot near an aligned pose, tabulated.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        height: Height of the end-effector about which the robot is linear [m].
        duration: Length of a step [s], above zero.

    Returns:
        The tables of `linear_step`.

    Raises:
        TypeError: If a carriage has another friction law.
    """
    aligned = jnp.zeros(5, height.dtype).at[4].set(height)
    plane = jnp.array(_PLANE)
    space = linearise(robot, aligned)
    matrix = space.state_matrix[plane][:, plane]
    mass, damping = masses(robot), dampings(robot)
    carriages = jnp.eye(8, dtype=matrix.dtype)[:, 6:]
    knocked = mass[0] * space.input_matrix[plane][:, 2:]
    forced = jnp.concatenate([carriages, knocked], axis=1)
    transition, responses = _exponentials(duration * matrix, forced)
    normal = 4 * robot.cable.effective_pretension
    vertical = jnp.array([[0.0, 1.0], [0.0, 0.0]], matrix.dtype)
    vertical = vertical.at[1, 1].set(-damping[4] / mass[4])
    moved, (lifted, _) = _exponentials(
        duration * vertical, duration * jnp.eye(2, dtype=matrix.dtype)[:, 1:]
    )
    return Propagator(
        duration=duration,
        transition=transition,
        responses=responses,
        pull=duration * matrix[6:, :4],
        coupling=jnp.square(duration) * matrix[4:, 2:4].T,
        damped=duration * (damping / mass)[2:4],
        limit=duration * friction_coefficients(robot) * normal / mass[2:4],
        height_transition=jnp.concatenate([moved[:, 1:], lifted], axis=1),
    )


def simulate_linear(
    robot: Robot,
    start: State,
    *,
    height: Float[Array, ""],
    interval: Float[Array, ""],
    voltage: Float[Array, "n 2"],
    knock: Float[Array, " n"] | None = None,
    substeps: int = 1,
) -> State:
    """Trajectory of the linear robot with exact Coulomb friction, on an even grid.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages; the dry friction of its
            drives has no part in the linear model.
        start: State at the first instant.
        height: Height of the end-effector about which the robot is linear [m].
        interval: Length of the intervals in which the inputs are held [s], above zero.
        voltage: Commands to the two drives in the `n` intervals [V].
        knock: Horizontal force on the end-effector in the intervals [N]; `None` for none.
        substeps: Steps in an interval; the error falls with their third power.

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
    tables = _unpacked(propagator(robot, height=height, duration=interval / substeps))
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
        State at the end; a carriage that sticks has a velocity of exactly zero.
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


def _exponentials(
    matrix: Float[Array, "n n"], forced: Float[Array, "n m"]
) -> tuple[Float[Array, "n n"], Float[Array, "2 n m"]]:
    r"""$e^Z$, and $\varphi_1(Z) B$, $\varphi_2(Z) B$ with $\varphi_k(z) = \sum z^j/(j+k)!$.

    By Taylor's series of $Z/2^d$ and by doubling,

    $$ \varphi_1(2z) = (e^z + 1)\,\varphi_1(z)/2, \qquad
       \varphi_2(2z) = (e^z \varphi_2(z) + \varphi_1(z) + \varphi_2(z))/4 $$

    Without a branch on the norm, so that it is batched and differentiated at its own cost.
    """
    small = matrix / 2**_DOUBLINGS
    identity = jnp.eye(matrix.shape[0], dtype=matrix.dtype)
    whole, second = identity, forced
    for term in range(_TERMS, 0, -1):
        whole = identity + small @ whole / term
        second = forced + small @ second / (term + 2)
    second = second / 2
    first = forced + small @ second
    for _ in range(_DOUBLINGS):
        second = (whole @ second + first + second) / 4
        first = (whole @ first + first) / 2
        whole = whole @ whole
    return whole, jnp.stack([first, second])


class _Tables(NamedTuple):
    """A propagator's tables as scalars, unpacked once: batched, each is an array of its own."""

    duration: Float[Array, ""]
    transition: tuple[Scalars, ...]
    responses: tuple[tuple[Scalars, ...], ...]
    pull: tuple[Scalars, ...]
    coupling: tuple[Scalars, ...]
    damped: Scalars
    limit: Scalars
    height_transition: tuple[Scalars, ...]


def _unpacked(tables: Propagator) -> _Tables:
    def scalars(array: Array) -> Array | tuple:
        return tuple(scalars(row) for row in array) if array.ndim else array

    return _Tables(*(scalars(getattr(tables, name)) for name in _Tables._fields))


class _Held(NamedTuple):
    """A carriage on the branch that it begins a step on, in velocity units."""

    branch: Float[Array, ""]
    acceleration: Float[Array, ""]
    load: Float[Array, ""]
    load_slope: Float[Array, ""]


def _step(tables: _Tables, state: Scalars, held: Scalars) -> Scalars:
    h = tables.duration
    x, y, v, climb = state[:4], state[4], state[5:9], state[9]
    drive, knock, lift = held
    pushed = (drive, jnp.zeros_like(drive))

    carriages = [_at_start(tables, i, x, v, pushed[i]) for i in range(2)]
    forces = tuple(once(f) for f in _assumed_forces(tables, carriages, pushed))
    ahead = _assumed_end(tables, (*x, *v), carriages, forces, knock=knock)
    ahead = tuple(once(value) for value in ahead)
    deviations = [
        deviation(_assumed(tables, i, carriage, v[2 + i], ahead, pushed[i]))
        for i, carriage in enumerate(carriages)
    ]

    position, velocity = list(ahead[:4]), list(ahead[4:])
    for i, found in enumerate(deviations):
        for j, coupling in enumerate(tables.coupling[i]):
            itself = j == 2 + i
            moved, sped = (
                found.answer(tables.damped[i], coupling) if itself else found.felt(coupling)
            )
            position[j] += h * moved
            velocity[j] += sped
    for i, found in enumerate(deviations):
        velocity[2 + i] = jnp.where(found.sticks, 0.0, velocity[2 + i])

    (coasts, lifts), (keeps, gains) = tables.height_transition
    return (
        *position,
        y + coasts * climb + lifts * lift,
        *velocity,
        keeps * climb + gains * lift,
    )


def _at_start(
    tables: _Tables, i: int, x: Scalars, v: Scalars, pushed: Float[Array, ""]
) -> _Held:
    """Branch, free acceleration and load of a carriage as the step begins."""
    h, row = tables.duration, tables.pull[i]
    load = sum(row[j] * x[j] for j in range(4)) + h * pushed
    slope = h * sum(row[j] * v[j] for j in range(4))
    speed, limit = v[2 + i], tables.limit[i]
    branch = branch_at_start(speed, load, limit)
    acceleration = load - tables.damped[i] * speed - branch * limit
    return _Held(branch, jnp.where(branch == 0, 0.0, acceleration), load, slope)


def _assumed_forces(tables: _Tables, carriages: list[_Held], pushed: Scalars) -> Scalars:
    """What acts on the carriages on the assumed branches, constant and rising [m/s].

    Friction is constant on a carriage that slides; on one that is held it is the load, but
    for its curvature, which is known only at the step's end.
    """
    h = tables.duration
    steady, rising = [], []
    for i, carriage in enumerate(carriages):
        rests = carriage.branch == 0
        friction = jnp.where(rests, carriage.load, carriage.branch * tables.limit[i])
        steady.append(h * pushed[i] - friction)
        rising.append(jnp.where(rests, -carriage.load_slope, 0.0))
    return (*steady, *rising)


def _assumed_end(
    tables: _Tables,
    state: Scalars,
    carriages: list[_Held],
    forces: Scalars,
    *,
    knock: Float[Array, ""],
) -> Scalars:
    """The step's end on the assumed branches."""
    constant, growing = tables.responses
    pulse = tables.duration * knock
    end = [
        sum(tables.transition[k][j] * state[j] for j in range(8))
        + sum(constant[k][i] * forces[i] + growing[k][i] * forces[2 + i] for i in range(2))
        + constant[k][2] * pulse
        for k in range(8)
    ]
    for i, carriage in enumerate(carriages):
        end[2 + i] = jnp.where(carriage.branch == 0, state[2 + i], end[2 + i])
        end[6 + i] = jnp.where(carriage.branch == 0, 0.0, end[6 + i])
    return tuple(end)


def _assumed(
    tables: _Tables,
    i: int,
    carriage: _Held,
    speed: Float[Array, ""],
    end: Scalars,
    pushed: Float[Array, ""],
) -> Assumed:
    """The carriage's motion and load through the step, as polynomials in its time."""
    h, row = tables.duration, tables.pull[i]
    load, slope, linear = carriage.load, carriage.load_slope, carriage.acceleration
    last = sum(row[j] * end[j] for j in range(4)) + h * pushed
    curve = once(last - load - slope)
    quadratic = end[6 + i] - speed - linear
    end_slope = last - tables.damped[i] * end[6 + i] - carriage.branch * tables.limit[i]
    return Assumed(
        branch=carriage.branch,
        velocity=Quadratic(speed, linear, quadratic),
        bend=end_slope - linear - 2 * quadratic,
        load=Quadratic(load, slope, curve),
        limit=tables.limit[i],
        unheld=jnp.where(carriage.branch == 0, curve, 0.0),
        stiffness=-h * row[2 + i],
    )
