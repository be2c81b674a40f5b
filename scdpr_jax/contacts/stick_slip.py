r"""One carriage under set-valued Coulomb friction within one short step.

A step begins on a branch: sliding forwards (+1), backwards (-1) or held (0). A smooth
integrator carries it through on that branch; this module finds where the carriage leaves
it and how much the true friction then differs from the assumed one.

Time runs from 0 to 1 through the step, and accelerations are multiplied by the step's
length, so that everything here is a velocity [m/s].
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.numerics.once import once

Scalars = tuple[Float[Array, ""], ...]
"""A scalar for each of some coordinates."""


class Quadratic(NamedTuple):
    """A polynomial of second degree in the step's time."""

    constant: Float[Array, ""]
    linear: Float[Array, ""]
    quadratic: Float[Array, ""]

    def __call__(self, time: Float[Array, ""] | float) -> Float[Array, ""]:
        """Value at a time of the step."""
        return self.constant + time * (self.linear + time * self.quadratic)


class Assumed(NamedTuple):
    """A carriage's motion through the step on the branch that it began on."""

    branch: Float[Array, ""]
    """+1 or -1 while sliding, 0 while held."""
    velocity: Quadratic
    """Sliding velocity through its start, its slope there and its end; held: zero [m/s]."""
    bend: Float[Array, ""]
    """Slope of the velocity's end beyond that, which makes it a cubic [m/s]."""
    load: Quadratic
    """What friction must balance to hold the carriage where the branch takes it [m/s]."""
    limit: Float[Array, ""]
    """Largest friction [m/s]."""
    unheld: Float[Array, ""]
    """What the assumed friction of a held carriage lacks of the load's square term [m/s]."""
    stiffness: Float[Array, ""]
    """The cables' stiffness against the carriage, times the step squared over mass [1]."""


class Deviation(NamedTuple):
    """What the true friction does to the carriage beyond the assumed one."""

    moments: tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""], Float[Array, ""]]
    r"""$E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$, d the difference, up to E_3 [m/s]."""
    pulls: tuple[Float[Array, ""], Float[Array, ""]]
    """E_2 and E_3 with what the assumed friction lacked while it held the carriage: that
    moves whatever the cables tie to it, and not the carriage itself [m/s]."""
    sticks: Bool[Array, ""]
    """Whether the carriage stands still at the end of the step."""


def answer(
    moments: tuple[Float[Array, ""], ...],
    damped: Float[Array, "..."],
    coupling: Float[Array, "..."] | float,
) -> tuple[Array, Array]:
    r"""How a coordinate answers a deviation of its own friction [m/s].

    $$ \delta q / h = E_1 - ch E_2 / 2 + \kappa E_3 / 6, \qquad
       \delta v = E_0 - ch E_1 + \left((ch)^2 + \kappa\right) E_2 / 2 $$

    Args:
        moments: E_0 to E_3 [m/s].
        damped: Damping over mass, times the step's length, $ch$ [1].
        coupling: Acceleration of the coordinate per displacement of its own, times the step's
            length squared, $\kappa$ [1].

    Returns:
        Its displacement over the step's length and its velocity, to be added to the assumed
        motion's end.
    """
    zeroth, first, second, third = moments
    return (
        first - damped * second / 2 + coupling * third / 6,
        zeroth - damped * first + (jnp.square(damped) + coupling) * second / 2,
    )


class Response(NamedTuple):
    """How the robot answers a coordinate with friction over a step, in units of the step."""

    damped: Float[Array, ""]
    """The coordinate's damping over its mass, times the step's length, $ch$ [1]."""
    couplings: dict[int, Float[Array, ""]]
    r"""Acceleration of each coordinate that the cables tie to it, per displacement of it, times
    the step's length squared, $\kappa$ [1 for a displacement]; its own is among them."""


def deviated(
    position: Scalars,
    velocity: Scalars,
    *,
    duration: Float[Array, ""],
    deviations: dict[int, Deviation],
    responses: dict[int, Response],
) -> tuple[list[Float[Array, ""]], list[Float[Array, ""]]]:
    r"""The end of a step under the true friction.

    What is tied to a coordinate by the cables feels of its deviation

    $$ \delta x / h = \kappa E_3 / 6, \qquad \delta v = \kappa E_2 / 2 $$

    and the coordinate itself answers as `answer` has it.

    Args:
        position: Coordinates at the assumed end [m, rad].
        velocity: Their velocities [m/s, rad/s].
        duration: Length of the step [s].
        deviations: What deviates, by coordinate.
        responses: How the robot answers each of them.

    Returns:
        Both as they are.
    """
    position, velocity = list(position), list(velocity)
    for i, own in deviations.items():
        second, third = own.pulls
        for j, coupling in responses[i].couplings.items():
            if j == i:
                moved, sped = answer(own.moments, responses[i].damped, coupling)
            else:
                moved, sped = coupling * third / 6, coupling * second / 2
            position[j] += duration * moved
            velocity[j] += sped
    return position, velocity


def branch_at_start(
    velocity: Float[Array, "..."], load: Float[Array, "..."], limit: Float[Array, "..."]
) -> Float[Array, "..."]:
    """The branch on which a carriage begins a step.

    Args:
        velocity: Velocity at the beginning; exactly zero for a carriage that sticks.
        load: Force that friction has to balance.
        limit: Largest friction, in the load's unit.

    Returns:
        Its direction if it moves, 0 if friction holds it, otherwise the load's direction.
    """
    pushed = jnp.where(jnp.abs(load) > limit, jnp.sign(load), 0.0)
    return jnp.where(velocity != 0, jnp.sign(velocity), pushed)


def deviation(assumed: Assumed) -> Deviation:
    r"""Where the carriage leaves its branch, and how far the friction then deviates.

    A sliding carriage stops where its velocity passes zero. There the load decides: above
    the limit it slides on the other way, otherwise it sticks until the load passes the
    limit. A held carriage breaks away where the load passes the limit.

    Args:
        assumed: The motion on the branch that the carriage began on.

    Returns:
        Moments of the deviation and whether the carriage sticks in the end.
    """
    assumed = assumed._replace(velocity=Quadratic(*map(once, assumed.velocity)))
    branch, limit = assumed.branch, assumed.limit
    slides = branch != 0
    stop, stops = _stop(assumed)
    stop = once(stop)
    load = Quadratic(*map(once, _load_when_stopped(assumed, stop, stops)))

    friction = branch * limit
    # Where the load falls below the limit so soon that it would be back in this step, it is
    # held: one step has one departure.
    back = _moment(0, _tail(load._replace(constant=load.constant + friction), stop))
    reverses = stops & (-branch * load(stop) > limit) & (branch * back < 0)
    holds = (stops & ~reverses) | ~slides
    release = once(_release(load, limit, stop, holds))

    # Assumed minus true friction from the stop on, and what the release adds to that. What
    # doesn't happen has its instant at the step's end, where its moments are zero.
    rests = slides & ~reverses
    stopped = Quadratic(
        jnp.where(rests, friction - load.constant, jnp.where(reverses, 2 * friction, 0.0)),
        jnp.where(rests, -load.linear, 0.0),
        jnp.where(rests, -load.quadratic, 0.0),
    )
    released = load._replace(constant=load.constant - jnp.sign(load(1.0)) * limit)
    tails = [_tail(stopped, stop), _tail(released, release)]
    moments = tuple(once(_moment(order, *tails)) for order in range(4))
    return deviating(moments, assumed.unheld, sticks=holds & (release == 1))


def deviating(
    moments: tuple[Float[Array, ""], ...], unheld: Float[Array, ""], *, sticks: Bool[Array, ""]
) -> Deviation:
    """The deviation with these moments.

    Args:
        moments: E_0 to E_3 [m/s].
        unheld: What the assumed friction lacked of the load's square term [m/s].
        sticks: Whether the coordinate stands still at the end of the step.

    Returns:
        The deviation.
    """
    # The moments of the square term are 2 k!/(k+3)!.
    pulls = (once(moments[2] - unheld / 30), once(moments[3] - unheld / 60))
    return Deviation(moments, pulls, sticks)


def _stop(assumed: Assumed) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    """First zero of the sliding velocity after the beginning; 1 or 0 without one."""
    branch, (start, linear, quadratic) = assumed.branch, assumed.velocity
    discriminant = jnp.square(linear) - 4 * quadratic * start
    real = discriminant > 0
    denominator = branch * jnp.sqrt(jnp.where(real, discriminant, 1.0)) - linear
    found = real & (branch * denominator > 0)
    moving = jnp.where(found, 2 * start / jnp.where(found, denominator, 1.0), 1.0)
    # From rest the beginning itself is a zero; the other one is where it turns back.
    turns = linear * quadratic < 0
    from_rest = jnp.where(turns, -linear / jnp.where(turns, quadratic, 1.0), 1.0)
    time = jnp.where(start == 0, from_rest, moving)
    stops = (branch != 0) & (time < 1)
    time = jnp.where(stops, time, 1.0)
    reserve = Quadratic(branch * start, branch * linear, branch * quadratic)
    closer = nearer(reserve, branch * assumed.bend, time)
    return jnp.where(branch == 0, 0.0, jnp.where(stops, closer, 1.0)), stops


def nearer(
    reserve: Quadratic, bend: Float[Array, ""], time: Float[Array, ""]
) -> Float[Array, ""]:
    r"""A zero of a quadratic that falls there, one step of Newton's nearer to that of a cubic.

    The cubic is the quadratic and $b\,\theta^2(\theta - 1)$, with the bend $b$.

    Args:
        reserve: The quadratic.
        bend: The bend.
        time: Its zero.

    Returns:
        The nearer one, within the step.
    """
    excess = bend * jnp.square(time) * (time - 1)
    slope = reserve.linear + time * (2 * reserve.quadratic + bend * (3 * time - 2))
    falls = slope < 0
    correction = jnp.where(falls, excess / jnp.where(falls, slope, 1.0), 0.0)
    return jnp.clip(time - correction, 0.0, 1.0)


def _load_when_stopped(
    assumed: Assumed, stop: Float[Array, ""], stops: Bool[Array, ""]
) -> Quadratic:
    """The holding load of a carriage that stays where it stopped.

    The assumed motion slides on past the stop; the cables' pull is put back by what that
    displacement changes.
    """
    start, linear, quadratic = assumed.velocity
    slid = stop * (start + stop * (linear / 2 + stop * quadratic / 3))
    stiffness = jnp.where(stops, assumed.stiffness, 0.0)
    return Quadratic(
        assumed.load.constant - stiffness * slid,
        assumed.load.linear + stiffness * start,
        assumed.load.quadratic + stiffness * linear / 2,
    )


def _release(
    load: Quadratic, limit: Float[Array, ""], stop: Float[Array, ""], holds: Bool[Array, ""]
) -> Float[Array, ""]:
    """When the load of a held carriage passes the limit; the step's end if it doesn't."""
    side = jnp.sign(load(1.0))
    breaks_away = holds & (jnp.abs(load(1.0)) > limit)
    surplus = load(stop) - side * limit
    slope = load.linear + 2 * load.quadratic * stop
    discriminant = jnp.square(slope) - 4 * load.quadratic * surplus
    real = breaks_away & (discriminant > 0)
    denominator = -slope - side * jnp.sqrt(jnp.where(real, discriminant, 1.0))
    found = real & (denominator != 0)
    held_for = jnp.where(found, 2 * surplus / jnp.where(found, denominator, 1.0), 0.0)
    return jnp.where(breaks_away, jnp.clip(stop + held_for, stop, 1.0), 1.0)


class _Tail(NamedTuple):
    """A polynomial from an instant to the step's end, in the share of that time left."""

    left: Float[Array, ""]
    coefficients: Quadratic


def _tail(polynomial: Quadratic, begin: Float[Array, ""]) -> _Tail:
    left = 1 - begin
    _, linear, quadratic = polynomial
    coefficients = Quadratic(
        polynomial(1.0), -left * (linear + 2 * quadratic), jnp.square(left) * quadratic
    )
    return _Tail(left, Quadratic(*map(once, coefficients)))


def _moment(order: int, *tails: _Tail) -> Float[Array, ""]:
    r"""$\int (1-\theta)^k p(\theta)\,d\theta$ over tails, k the order."""
    k = order + 1
    return sum(
        left**k * (constant / k + linear / (k + 1) + quadratic / (k + 2))
        for left, (constant, linear, quadratic) in tails
    )
