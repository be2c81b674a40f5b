r"""One carriage under set-valued Coulomb friction within one short step.

A step begins on a branch: sliding forwards (+1), backwards (-1) or held (0). A smooth
integrator carries it through on that branch; this module finds where the carriage leaves it
and how much the true friction then differs from the assumed one. One stop and one release are
all that a step has, both in closed form, so that there is no loop and derivatives hold through
both instants. A smoothed friction would need no events, but is another model, stiff and wrong
by more than a camera sees; projecting a step's end onto the friction's cone is of first order.

Time runs from 0 to 1 through the step, and accelerations are multiplied by the step's
length, so that everything here is a velocity [m/s].
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.contacts.polynomial import Cubic, Quadratic, fall, falling_zero, moment
from scdpr_jax.contacts.response import Departure, Moments, deviating


class Assumed(NamedTuple):
    """A carriage's motion through the step on the branch that it began on."""

    branch: Float[Array, ""]
    """+1 or -1 while sliding, 0 while held."""
    velocity: Cubic
    """Sliding velocity through its start and its end, with its slopes there; held: zero
    [m/s]."""
    load: Quadratic
    """What friction must balance to hold the carriage where the branch takes it [m/s]."""
    limit: Float[Array, ""]
    """Largest friction [m/s]."""
    stiffness: Float[Array, ""]
    """The cables' stiffness against the carriage, times the step squared over mass [1]."""


class Deviation(NamedTuple):
    """What the true friction does to the carriage beyond the assumed one."""

    moments: Moments
    r"""$E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$, d the difference, up to E_3 [m/s]."""
    sticks: Bool[Array, ""]
    """Whether the carriage stands still at the end of the step."""

    def departure(self, i: int, unheld: Float[Array, ""] | None = None) -> Departure:
        """How the carriage leaves its branch.

        Args:
            i: Its coordinate.
            unheld: What the assumed friction lacked of the load's square term [m/s].

        Returns:
            Its deviation and, where it sticks, its rest.
        """

        def at_rest(velocity: Float[Array, "5"]) -> dict[int, Float[Array, ""]]:
            return {i: jnp.where(self.sticks, 0.0, velocity[i])}

        return Departure({i: deviating(self.moments, unheld)}, at_rest)


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


def leaves(assumed: Assumed) -> Bool[Array, ""]:
    """Whether the carriage leaves the branch that it began the step on.

    Args:
        assumed: The motion on that branch.

    Returns:
        Whether it does; if not, its `deviation` is nothing.
    """
    breaks_away = jnp.abs(assumed.load(1.0)) > assumed.limit
    return jnp.where(assumed.branch == 0, breaks_away, _stop(assumed)[1])


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
    branch, limit = assumed.branch, assumed.limit
    slides = branch != 0
    stop, stops = _stop(assumed)
    load = _load_when_stopped(assumed, stop, stops)

    friction = branch * limit
    # Where the load falls below the limit so soon that it would be back in this step, it is
    # held: one step has one departure.
    back = moment(0, 1 - stop, load._replace(constant=load.constant + friction).later(stop))
    reverses = stops & (-branch * load(stop) > limit) & (branch * back < 0)
    holds = (stops & ~reverses) | ~slides
    release = _release(load, limit, stop, holds)

    # Assumed minus true friction from the stop on, and what the release adds to that. What
    # doesn't happen has its instant at the step's end, where its moments are zero.
    rests = slides & ~reverses
    stopped = Quadratic(
        jnp.where(rests, friction - load.constant, jnp.where(reverses, 2 * friction, 0.0)),
        jnp.where(rests, -load.linear, 0.0),
        jnp.where(rests, -load.quadratic, 0.0),
    )
    released = load._replace(constant=load.constant - jnp.sign(load(1.0)) * limit)
    changes = [
        (1 - instant, change.later(instant))
        for instant, change in ((stop, stopped), (release, released))
    ]
    moments = tuple(sum(moment(k, *change) for change in changes) for k in range(4))
    return Deviation(moments, holds & (release == 1))


def _stop(assumed: Assumed) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    """First zero of the sliding velocity after the beginning; 1 or 0 without one."""
    branch, (velocity, bend) = assumed.branch, assumed.velocity
    reserve = Cubic(Quadratic(*(branch * part for part in velocity)), branch * bend)
    time, falls = fall(reserve, left=1.0, set_going=velocity.constant == 0)
    stops = (branch != 0) & falls
    return jnp.where(branch == 0, 0.0, jnp.where(stops, time, 1.0)), stops


def _load_when_stopped(
    assumed: Assumed, stop: Float[Array, ""], stops: Bool[Array, ""]
) -> Quadratic:
    """The holding load of a carriage that stays where it stopped.

    The assumed motion slides on past the stop; the cables' pull is put back by what that
    displacement changes.
    """
    start, linear, quadratic = assumed.velocity.quadratic
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
    reserve = Quadratic(
        limit - side * load.constant, -side * load.linear, -side * load.quadratic
    )
    # Without a zero the load is beyond the limit from the beginning.
    held_for, _ = falling_zero(reserve.later(stop))
    return jnp.where(breaks_away, jnp.clip(stop + held_for, stop, 1.0), 1.0)
