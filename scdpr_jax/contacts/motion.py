r"""Lower carriage, height and drives between two events of a step, as polynomials.

A step's motion between events isn't integrated: the loads are polynomials of the step's own
time, known from its stages, and on a branch the pair is so light a system (two coordinates,
one stiffness) that its velocities are quadratics in the time since the event. That is enough,
as events of one step lie close together, and makes the next event a closed form. Stepping anew
from the event would be simpler to say, and dearer by a step for each.

Time runs from 0 to 1 through the step, and forces are multiplied by the step's length, so
that they are momenta [N s].
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.contacts.branches import Branch, Contacts, Pair, Three, act, less
from scdpr_jax.contacts.polynomial import Cubic, Quadratic, combination

Quadratics = tuple[Quadratic, Quadratic]
"""Of the lower carriage and of the height, in the step's time."""
Cubics = tuple[Cubic, Cubic]
"""Likewise."""


class Assumed(NamedTuple):
    """The pair's motion through the step on the branch that it began on."""

    branch: Branch
    mobility: Three
    """The branch's [1/kg]."""
    velocity: Cubics
    """Velocities through their starts and ends, with their slopes there [m/s]."""
    load: Quadratics
    """All forces but dry friction and damping [N s]."""
    damping: Pair
    """Viscous damping, times the step's length [kg]."""
    stiffness: Float[Array, ""]
    """The cables' stiffness against the lower carriage, times the step squared [kg]."""


class Motion(NamedTuple):
    """The true motion from an event on, in the time since then."""

    begin: Float[Array, ""]
    branch: Branch
    fresh: Three
    """Marks contacts that were at rest at the beginning."""
    velocity: Cubics
    """Bent as the assumed motion until the first event, straight quadratics from then on."""
    load: Quadratics
    """All forces but dry friction, damping included."""
    pull: Quadratics
    """The load less the friction of what slides."""
    friction: Quadratics
    """All friction over the masses."""


def motion_on(
    branch: Branch,
    *,
    mobility: Three,
    begin: Float[Array, ""],
    fresh: Three,
    velocity: Cubics,
    load: Quadratics,
    contacts: Contacts,
) -> Motion:
    """The motion on a branch.

    Args:
        branch: The branch.
        mobility: The branch's [1/kg].
        begin: When it begins.
        fresh: Marks contacts that were at rest then.
        velocity: Velocities [m/s].
        load: All forces but dry friction [N s].
        contacts: The contacts.

    Returns:
        The motion.
    """
    slide = branch.friction(contacts.limit)
    pull = tuple(p._replace(constant=p.constant - f) for p, f in zip(load, slide, strict=True))
    # What is held takes what its contact leaves of the pull, over the masses.
    lower, across, height = mobility
    held = (1 / contacts.mass[0] - lower, 1 / contacts.mass[1] - height)
    friction = []
    for i in range(2):
        rest = combination((held[i], pull[i]), (-across, pull[1 - i]))
        friction.append(rest._replace(constant=rest.constant + slide[i] / contacts.mass[i]))
    return Motion(begin, branch, fresh, velocity, load, pull, tuple(friction))


def beginning(assumed: Assumed, fresh: Three, contacts: Contacts) -> Motion:
    """The motion as a step begins: the assumed one.

    Args:
        assumed: The assumed motion.
        fresh: Marks contacts that are at rest.
        contacts: The contacts.

    Returns:
        The motion.
    """
    load = tuple(
        combination((1, p), (-c, v.quadratic))
        for p, c, v in zip(assumed.load, assumed.damping, assumed.velocity, strict=True)
    )
    return motion_on(
        assumed.branch,
        mobility=assumed.mobility,
        begin=jnp.zeros_like(assumed.stiffness),
        fresh=fresh,
        velocity=assumed.velocity,
        load=load,
        contacts=contacts,
    )


def onwards(
    assumed: Assumed,
    branch: Branch,
    *,
    begin: Float[Array, ""],
    fresh: Three,
    velocity: Pair,
    load: Pair,
    contacts: Contacts,
) -> Motion:
    """The motion on a branch from an instant on, as the assumed loads go on from there.

    Args:
        assumed: The assumed motion.
        branch: The branch.
        begin: The instant.
        fresh: Marks contacts that were at rest then.
        velocity: Velocities then [m/s].
        load: All forces but dry friction then [N s].
        contacts: The contacts.

    Returns:
        The motion.
    """
    mobility = branch.mobility(contacts.mass)
    gain = act(mobility, less(load, branch.friction(contacts.limit)))
    lower, height = (
        p.later(begin).linear - c * a
        for p, c, a in zip(assumed.load, assumed.damping, gain, strict=True)
    )
    # The cables feel how far the carriage strays from the assumed motion.
    led = assumed.velocity[0].quadratic.later(begin)
    strayed = assumed.stiffness * (velocity[0] - led.constant)
    straying = assumed.stiffness * (gain[0] - led.linear)
    linear = (lower - strayed, height)
    quadratic = (assumed.load[0].quadratic - straying / 2, assumed.load[1].quadratic)
    bending = act(mobility, linear)
    straight = jnp.zeros_like(begin)
    return motion_on(
        branch,
        mobility=mobility,
        begin=begin,
        fresh=fresh,
        velocity=tuple(
            Cubic(Quadratic(v, a, j / 2), straight)
            for v, a, j in zip(velocity, gain, bending, strict=True)
        ),
        load=tuple(Quadratic(*parts) for parts in zip(load, linear, quadratic, strict=True)),
        contacts=contacts,
    )
