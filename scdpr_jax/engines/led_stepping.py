r"""The end-effector and the upper carriage while the drives lead the rest, step by step.

Where dynamics inversion leads the drives, the lower carriage and the height are where their
references are, whatever the cables pull. What is left to find are the undriven coordinates
$[x_e, \delta_e, q_4]$ with one contact, the upper carriage's: no drive, no controller, and
$q_3(t)$, $y_e(t)$ given. A step is Runge and Kutta's of fourth order on the branch that the
contact begins it on, and `scdpr_jax.contacts.single` finds how the carriage leaves that, in
closed form. The engine of the whole robot (`scdpr_jax.engines.stepping`) needs two and a half
times the operations, and samples of the controller's period.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from equinox.internal import unvmap_any
from jaxtyping import Array, Float

from scdpr_jax.contacts import single
from scdpr_jax.contacts.polynomial import Quadratic, cubic_between
from scdpr_jax.contacts.response import answer
from scdpr_jax.engines.stepping import exact_laws
from scdpr_jax.robot.cable import carriage_stiffness, loop_forces
from scdpr_jax.robot.dynamics import dampings, masses
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import TILT, UPPER, X

UNDRIVEN = (X, TILT, UPPER)
"""The coordinates that no drive leads."""
_CARRIAGE = 2
"""The upper carriage's place among them."""


class Undriven(NamedTuple):
    """The undriven coordinates and their velocities."""

    position: Float[Array, "... 3"]
    r"""$[x_e, \delta_e, q_4]$ [m, rad, m]."""
    velocity: Float[Array, "... 3"]
    """Its time derivative [m/s, rad/s, m/s]."""


class Lead(NamedTuple):
    """Where the drives lead the rest at a step's beginning, in its middle and at its end."""

    lower: Float[Array, "... 3"]
    """The lower carriage, $q_3$ [m]."""
    height: Float[Array, "... 3"]
    """The end-effector's height $y_e$ [m]."""


def thirds(halves: Float[np.ndarray, "points ..."]) -> Float[np.ndarray, "steps 3 ..."]:
    """Beginning, middle and end of each step: what a `Lead` is made of.

    Args:
        halves: What is led, at every half step.

    Returns:
        A row for each step.
    """
    return np.stack([halves[:-1:2], halves[1::2], halves[2::2]], axis=1)


def whole_position(
    position: Float[Array, "3"], lower: Float[Array, ""], height: Float[Array, ""]
) -> Float[Array, "5"]:
    r"""All coordinates of the robot.

    Args:
        position: The undriven ones [m, rad, m].
        lower: The lower carriage, $q_3$ [m].
        height: The end-effector's height $y_e$ [m].

    Returns:
        $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].
    """
    x, tilt, upper = jnp.unstack(position)
    return jnp.stack([x, tilt, lower, upper, height])


class _Stage(NamedTuple):
    """A stage of the step, with what acts over the masses [m/s², rad/s²]."""

    velocity: Float[Array, "3"]
    load: Float[Array, "3"]
    """All but dry friction."""
    limit: Float[Array, ""]
    """The upper carriage's largest friction."""
    slope: Float[Array, "3"]
    """Acceleration on the branch."""


@jax.custom_jvp
def _balance(
    robot: Robot, at: Undriven, lower: Float[Array, ""], height: Float[Array, ""]
) -> tuple[Float[Array, "3"], Float[Array, ""]]:
    """What acts over the masses but dry friction, and the upper carriage's largest friction.

    Its Jacobian is multiplied out before tangents come (that is what machine code makes of a
    function with a derivative of its own): a leg has dozens of them, and four balances a step.
    """
    mass, damping = (jnp.stack([of(robot)[i] for i in UNDRIVEN]) for of in (masses, dampings))
    loop = loop_forces(robot, whole_position(at.position, lower, height))
    pull = jnp.stack([loop.pull[i] for i in UNDRIVEN])
    coefficient = exact_laws(robot)[1].sliding(at.velocity[_CARRIAGE])
    limit = coefficient * loop.normal[1] / mass[_CARRIAGE]
    return (pull - damping * at.velocity) / mass, limit


@_balance.defjvp
def _balance_jvp(primals: tuple, tangents: tuple) -> tuple:
    return jax.jvp(_balance.fun, primals, tangents)


def step(robot: Robot, state: Undriven, lead: Lead, duration: Float[Array, ""]) -> Undriven:
    """The undriven coordinates after a step.

    Args:
        robot: The robot, with `Coulomb` friction on the upper carriage.
        state: State at the beginning.
        lead: Where the drives lead the rest.
        duration: Length of the step [s].

    Returns:
        State at the end; a carriage that sticks has a velocity of exactly zero.

    Raises:
        TypeError: If a carriage has another friction law.
    """
    mass, damping = (jnp.stack([of(robot)[i] for i in UNDRIVEN]) for of in (masses, dampings))
    driven = tuple(zip(jnp.unstack(lead.lower), jnp.unstack(lead.height), strict=True))

    def balance(at: Undriven, place: int) -> tuple[Array, Array]:
        return _balance(robot, at, *driven[place])

    load, limit = balance(state, 0)
    branch = single.branch_at_start(state.velocity[_CARRIAGE], load[_CARRIAGE], limit)

    def stage(at: Undriven, load: Array, limit: Array) -> _Stage:
        free = jnp.square(branch) * load[_CARRIAGE] - branch * limit
        return _Stage(at.velocity, load, limit, jnp.stack([load[0], load[1], free]))

    def ahead(*parts: tuple[float, _Stage]) -> Undriven:
        return Undriven(
            state.position + sum(duration * w * own.velocity for w, own in parts),
            state.velocity + sum(duration * w * own.slope for w, own in parts),
        )

    def next_stage(before: _Stage, share: float, place: int) -> _Stage:
        at = ahead((share, before))
        return stage(at, *balance(at, place))

    first = stage(state, load, limit)
    second = next_stage(first, 1 / 2, 1)
    third = next_stage(second, 1 / 2, 1)
    last = next_stage(third, 1.0, 2)
    end = ahead((1 / 6, first), (1 / 3, second), (1 / 3, third), (1 / 6, last))
    position = whole_position(state.position, *driven[0])
    row = -jnp.square(duration) * carriage_stiffness(robot, position)[1]
    coupling = jnp.stack([row[i] for i in UNDRIVEN]) / mass
    damped = duration * damping[_CARRIAGE] / mass[_CARRIAGE]
    assumed = _assumed(duration, branch, (first, third, last), end, damped, coupling)

    def departed(end: Undriven) -> Undriven:
        return _departed(end, single.deviation(assumed), duration, damped, coupling)

    # Few steps have an event; in a batch all runs take the way of those that have one.
    event = unvmap_any(single.leaves(assumed))
    return jax.lax.cond(event, departed, lambda end: end, end)


def _assumed(
    duration: Float[Array, ""],
    branch: Float[Array, ""],
    stages: tuple[_Stage, _Stage, _Stage],
    end: Undriven,
    damped: Float[Array, ""],
    coupling: Float[Array, "3"],
) -> single.Assumed:
    """The upper carriage's motion on the branch, as polynomials in the step's time."""
    i = _CARRIAGE
    begin, _, last = stages
    velocity = cubic_between(
        begin.velocity[i],
        end.velocity[i],
        slope=duration * begin.slope[i],
        end_slope=duration * last.slope[i],
    )
    a, b, c = (duration * own.load[i] + damped * own.velocity[i] for own in stages)
    return single.Assumed(
        branch=branch,
        velocity=velocity,
        load=Quadratic(a, 4 * b - 3 * a - c, 2 * (a + c) - 4 * b),
        limit=duration * stages[1].limit,
        stiffness=-coupling[i],
    )


def _departed(
    end: Undriven,
    deviation: single.Deviation,
    duration: Float[Array, ""],
    damped: Float[Array, ""],
    coupling: Float[Array, "3"],
) -> Undriven:
    """The step's end under the true friction, `scdpr_jax.contacts.response.departed`."""
    _, _, second, third = deviation.moments
    moved, sped = answer(deviation.moments, damped, coupling[_CARRIAGE])
    moves = jnp.stack([*(coupling[:_CARRIAGE] * third / 6), moved])
    speeds = jnp.stack([*(coupling[:_CARRIAGE] * second / 2), sped])
    velocity = end.velocity + speeds
    rest = jnp.where(deviation.sticks, 0.0, velocity[_CARRIAGE])
    return Undriven(end.position + duration * moves, jnp.stack([*velocity[:_CARRIAGE], rest]))
