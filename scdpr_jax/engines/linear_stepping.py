r"""The fixed-grid engine of the linear model: exact between events, for one run or millions.

Near an aligned pose at a height the robot is linear but for its dry friction, Eqs. (18) and
(21) with the drives. On the branches that the contacts begin a step on, a step is a product
with tabulated matrices (`scdpr_jax.engines.propagator`) and has no error of its own; where a
contact leaves its branch, `scdpr_jax.contacts.single` and `scdpr_jax.contacts.events` say when
and by how much the friction deviates. So the error is the events' alone, and falls with nearly
the fourth power of the step (3.9 measured, see `docs/validity.md`).

Why so: the nonlinear engine's stages would give the same at four times the work, and a solver
that stops at every event can't be batched, as its runs have different numbers of steps.
"""

from collections.abc import Mapping
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.contacts.linear import AssumedFriction, Start, carriage, pulleys
from scdpr_jax.contacts.response import departed
from scdpr_jax.engines.arguments import (
    check_finite,
    check_shape,
    check_start,
    possible_substeps,
)
from scdpr_jax.engines.propagator import Propagator, propagator
from scdpr_jax.engines.stepping import with_start
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import drive_forces, masses
from scdpr_jax.robot.fields import concrete, real, refuse
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State, X, possible_height


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
        substeps: Steps in an interval; the error falls with nearly their fourth power.
        rubbing_drives: Whether the drives' dry friction is followed. Where they have none, a
            run without it is the same and takes less than half the time.

    Returns:
        States at the `n + 1` ends of the intervals, the start first.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If `substeps` is below 1, a shape is another, the height isn't within the
            frame, the interval isn't above zero, or a number isn't finite.
    """
    substeps = possible_substeps(substeps)
    check_start(robot, start)
    check_shape(voltage, ("n", 2), name="voltage", unit="V")
    check_finite(voltage, name="voltage", unit="V")
    if knock is not None:
        check_shape(knock, jnp.shape(voltage)[:1], name="knock", unit="N")
        check_finite(knock, name="knock", unit="N")
    height = possible_height(robot, height)
    tables = propagator(
        robot,
        height=height,
        duration=_positive(interval) / substeps,
        rubbing_drives=rubbing_drives,
    )
    held = _Held(voltage, jnp.zeros_like(voltage[:, 0]) if knock is None else knock)
    _, states = native.run(_advance, _Interval(robot, tables, substeps), start, held)
    return with_start(start, states)


def _positive(interval: Float[Array, ""]) -> Float[Array, ""]:
    check_shape(interval, (), name="interval", unit="s")
    message = (
        "`interval` must be above zero and finite [s], got one that isn't. Give the time "
        "between two rows of the inputs."
    )
    known = concrete(real(interval))
    return refuse(interval, ~((known > 0) & (known < jnp.inf)), message)


class _Held(NamedTuple):
    """Inputs of an interval, or of all."""

    voltage: Float[Array, "... 2"]
    knock: Float[Array, "..."]


class _Interval(eqx.Module):
    """What an interval of held inputs needs to know.

    What a voltage does is worked out there, so that derivatives are by the robot's numbers and
    not by those of all intervals.
    """

    robot: Robot
    tables: Propagator
    """A tabulated step."""
    substeps: int = eqx.field(static=True)
    """Steps in the interval."""


def _advance(interval: _Interval, state: State, held: _Held) -> tuple[State, State]:
    push = _accelerations(interval.robot, held.voltage, held.knock)
    following = jax.lax.fori_loop(
        0, interval.substeps, lambda _, now: _step(interval.tables, now, push), state
    )
    return following, following


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
    return _step(tables, state, _accelerations(robot, voltage, knock))


def _accelerations(
    robot: Robot, voltage: Float[Array, "2"], knock: Float[Array, ""]
) -> Float[Array, "3"]:
    """What the inputs do to the lower carriage, the end-effector and the height [m/s²]."""
    mass = masses(robot)
    forces = drive_forces(robot, motor_torque(robot.drive, voltage))
    weight = robot.gravity * robot.end_effector.mass
    return jnp.stack(
        [
            forces[LOWER] / mass[LOWER],
            knock / mass[X],
            (forces[HEIGHT] - weight) / mass[HEIGHT],
        ]
    )


def _step(tables: Propagator, state: State, push: Float[Array, "3"]) -> State:
    drive, knock, lift = tables.duration * push
    pushes = {LOWER: drive, UPPER: jnp.zeros_like(drive), HEIGHT: lift}
    start = Start(tables, state, pushes)
    lower = carriage(start, LOWER) if tables.drives is None else pulleys(start)
    contacts = (lower, carriage(start, UPPER))

    frictions = {i: f for contact in contacts for i, f in contact.friction().items()}
    end = _assumed_end(start, frictions, knock=knock)
    for contact in contacts:
        end = contact.held(end)
    return departed(
        end,
        [contact.departure(end) for contact in contacts],
        duration=tables.duration,
        responses={i: start.response(i) for i in frictions},
    )


def _assumed_end(
    start: Start, frictions: Mapping[int, AssumedFriction], *, knock: Float[Array, ""]
) -> State:
    r"""The step's end on the assumed branches, but for what they hold.

    $$ x_f = \Phi x + \varphi_1(hA)\, b\, (u - f) - \varphi_2(hA)\, b\, \dot f $$
    """
    tables, (q, v) = start.tables, (start.state.position, start.state.velocity)
    none = jnp.zeros_like(knock)
    steady = {
        i: push - frictions[i].constant if i in frictions else push
        for i, push in start.pushes.items()
    }
    rising = {i: -frictions[i].rising if i in frictions else none for i in start.pushes}
    constant, growing = tables.responses
    plane = (
        tables.transition @ jnp.concatenate([q[:HEIGHT], v[:HEIGHT]])
        + constant @ jnp.stack([steady[LOWER], steady[UPPER], knock])
        + growing @ jnp.stack([rising[LOWER], rising[UPPER], none])
    )
    lift, up = tables.height @ jnp.stack([v[HEIGHT], steady[HEIGHT], rising[HEIGHT]])
    return State(jnp.append(plane[:HEIGHT], q[HEIGHT] + lift), jnp.append(plane[HEIGHT:], up))
