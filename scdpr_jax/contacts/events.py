r"""Events of the lower carriage and the drives in a step: contacts stop, stick and give way.

Three contacts on two coordinates (`scdpr_jax.contacts.branches`) have no single closed form, as
one contact has (`scdpr_jax.contacts.single`): what stops first decides what the others do. So
the true motion is followed from event to event, at most `EVENTS` of them, and its friction's
difference from the assumed one is summed up as moments. Solving the contacts as a
complementarity problem in every step would be simpler, but knows no instants: it is of first
order, and its derivatives jump where a contact changes.

Time runs from 0 to 1 through the step, and forces are multiplied by the step's length, so
that they are momenta [N s].
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from equinox.internal import unvmap_any
from jaxtyping import Array, Bool, Float, Int

from scdpr_jax.contacts.branches import (
    DIRECTIONS,
    LINES,
    PAIR,
    Branch,
    Contacts,
    Pair,
    Three,
    act,
    along,
    decided,
    less,
    mark,
    weighted,
)
from scdpr_jax.contacts.motion import Assumed, Motion, beginning, onwards
from scdpr_jax.contacts.polynomial import Cubic, combination, fall, moment
from scdpr_jax.contacts.response import Departure, answer, deviating

EVENTS = 5
"""Events of one step that are followed; after them it stays on its branch, or at rest. All
three contacts may stop in one instant, three events, and give way again in the same step."""

LEAST_TO_BEND = 1e-3
"""Share of a step in which a velocity is straight, and only roundings would bend it [1]."""

SOON = 1e-6
"""Share of the time left in a step within which contacts give way together [1]."""


class Deviation(NamedTuple):
    """What the true friction does to the pair beyond the assumed one."""

    moments: tuple[Pair, Pair, Pair, Pair]
    r"""$E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$, d the difference over the masses,
    up to E_3 [m/s]."""
    branch: Branch
    """The branch at the end of the step."""

    def departure(self, mass: Pair, unheld: Pair | None = None) -> Departure:
        """How the pair leaves its branch.

        Args:
            mass: Masses of both coordinates [kg].
            unheld: What the assumed friction lacked of the loads' square terms [m/s].

        Returns:
            Its deviations and the rest of what sticks.
        """
        lacked = (None, None) if unheld is None else unheld
        moments = zip(*self.moments, strict=True)

        def at_rest(velocity: Float[Array, "5"]) -> dict[int, Float[Array, ""]]:
            pair = tuple(velocity[i] for i in PAIR)
            return dict(zip(PAIR, self.branch.exactly(pair, mass), strict=True))

        return Departure(dict(zip(PAIR, map(deviating, moments, lacked), strict=True)), at_rest)


class _Event(NamedTuple):
    """The first event of a motion, if it has one."""

    passed: Float[Array, ""]
    """Time since the motion's beginning; all that is left where nothing happens."""
    mark: Three
    """Marks the contact, or at the origin the line along which the pair may leave it."""
    towards: Three
    """Sides to which held contacts are pulled."""


class _Followed(NamedTuple):
    """What has been followed of a step."""

    motion: Motion
    """The motion from the last event on."""
    event: _Event
    """The next one."""
    moments: tuple[Pair, Pair, Pair, Pair]
    """Moments of the deviation until the last one."""


def deviation(assumed: Assumed, contacts: Contacts) -> Deviation:
    """Where the pair leaves its branch, and how far the friction then deviates.

    Args:
        assumed: The motion on the branch that the pair began on.
        contacts: The contacts.

    Returns:
        Moments of the deviation and the branch at the end.
    """
    speeds = along(DIRECTIONS, tuple(v.quadratic.constant for v in assumed.velocity))
    fresh = tuple(mark(speed == 0, speed) for speed in speeds)
    motion = beginning(assumed, fresh, contacts)
    event = _first_event(motion, contacts)
    none = jnp.zeros_like(motion.begin)
    nothing = Deviation(((none, none),) * 4, assumed.branch)

    def follow(done: _Followed, order: Int[Array, ""]) -> tuple[_Followed, None]:
        further = functools.partial(_further, assumed, contacts, order)
        return jax.lax.cond(_anywhere(done.event), further, lambda same: same, done), None

    def every(begun: _Followed) -> Deviation:
        # A loop, so that an event is compiled once.
        done, _ = jax.lax.scan(follow, begun, jnp.arange(EVENTS))
        return Deviation(done.moments, done.motion.branch)

    begun = _Followed(motion, event, nothing.moments)
    return jax.lax.cond(_anywhere(event), every, lambda _: nothing, begun)


def _anywhere(event: _Event) -> Bool[Array, ""]:
    """Whether there is an event in any run of a batch.

    Most steps have none in any of a few runs, and save the work. A run without one is the
    same to the bit where another's takes it along: all that changes is over no time.
    """
    return unvmap_any(sum(event.mark) > 0)


def _further(
    assumed: Assumed, contacts: Contacts, order: Int[Array, ""], done: _Followed
) -> _Followed:
    """Followed beyond the next event, which is the step's event of this order, from 0."""
    following = _after(assumed, done.motion, done.event, contacts, last=order == EVENTS - 1)
    change = tuple(
        combination((1, was.later(done.event.passed)), (-1, now))
        for was, now in zip(done.motion.friction, following.friction, strict=True)
    )
    left = 1 - following.begin
    moments = tuple(
        tuple(m + moment(k, left, c) for m, c in zip(pair, change, strict=True))
        for k, pair in enumerate(done.moments)
    )
    end = following.branch.exactly(_end(assumed, moments, contacts), contacts.mass)
    velocity = tuple(
        _through(v, to, left) for v, to in zip(following.velocity, end, strict=True)
    )
    following = following._replace(velocity=velocity)
    return _Followed(following, _first_event(following, contacts), moments)


def _end(assumed: Assumed, moments: tuple[Pair, ...], contacts: Contacts) -> Pair:
    """Velocities at the step's end by the deviation so far."""
    couplings = (-assumed.stiffness / contacts.mass[0], 0.0)
    parts = (assumed.velocity, zip(*moments, strict=True), assumed.damping, contacts.mass)
    return tuple(
        velocity.quadratic(1.0) + answer(deviated, damping / mass, coupling)[1]
        for velocity, deviated, damping, mass, coupling in zip(*parts, couplings, strict=True)
    )


def _through(velocity: Cubic, end: Float[Array, ""], left: Float[Array, ""]) -> Cubic:
    """The velocity bent to pass through the step's end, if there is time left to bend it.

    Otherwise a contact could stop just before the end and yet be on its old side there: it
    would stop once more in the next step, and derivatives would take the event twice.
    """
    constant, linear, quadratic = velocity.quadratic
    bends = left > LEAST_TO_BEND
    bent = (end - constant - left * linear) / jnp.square(jnp.where(bends, left, 1.0))
    quadratic = jnp.where(bends, bent, quadratic)
    return velocity._replace(quadratic=velocity.quadratic._replace(quadratic=quadratic))


def _after(
    assumed: Assumed,
    motion: Motion,
    event: _Event,
    contacts: Contacts,
    *,
    last: Bool[Array, ""],
) -> Motion:
    """The motion after its first event, the last of the step that is followed or not."""
    was, passed = motion.branch, event.passed
    begin = motion.begin + passed
    happens, on_line = sum(event.mark), sum(was.line)
    gives_way = sum(e * on for e, on in zip(event.mark, was.line, strict=True))
    # Along a line everything stops at once; out of a sector a contact stops alone.
    stops = on_line * (happens - gives_way)
    moves = 1 - stops
    resting = Branch(
        tuple(s * (1 - e) * moves for s, e in zip(was.side, event.mark, strict=True)),
        tuple(e * (1 - on_line - was.origin) for e in event.mark),
        stops + was.origin,
    )
    arrived = tuple(v(passed) for v in motion.velocity)
    velocity = resting.stopped(arrived, contacts)
    load = tuple(
        p(passed) + c * (v - now)
        for p, c, v, now in zip(motion.load, assumed.damping, arrived, velocity, strict=True)
    )
    # From the origin contacts may give way together: which, the load tells a little later.
    soon = passed + SOON * (1 - begin)
    telling = tuple(
        jnp.where(was.origin != 0, p(soon), now)
        for p, now in zip(motion.load, load, strict=True)
    )
    settles = happens - gives_way != 0
    branch = jax.tree.map(
        lambda settled, same: jnp.where(settles, settled, same),
        decided(resting, telling, contacts),
        _given_way(was, event, gives_way),
    )
    rested = _rests_if_it_turns(branch, velocity, load, happens * (1 - begin), contacts)
    branch = jax.tree.map(lambda rests, same: jnp.where(last, rests, same), rested, branch)
    return onwards(
        assumed,
        branch,
        begin=begin,
        fresh=tuple(jnp.minimum(e + resting.origin, 1.0) for e in event.mark),
        velocity=velocity,
        load=load,
        contacts=contacts,
    )


def _given_way(was: Branch, event: _Event, gives_way: Float[Array, ""]) -> Branch:
    """The branch after the held contact of a line gave way to the side of its pull."""
    return Branch(
        tuple(
            side + gives_way * on * towards
            for side, on, towards in zip(was.side, was.line, event.towards, strict=True)
        ),
        tuple(on * (1 - gives_way) for on in was.line),
        was.origin,
    )


def _rests_if_it_turns(
    branch: Branch, velocity: Pair, load: Pair, left: Float[Array, ""], contacts: Contacts
) -> Branch:
    """The branch after the last event that is followed: at rest, if it stops before the end.

    What zigzags to rest in more events than are followed would pass it otherwise, and turn
    round in every step from then on.
    """
    gain = act(branch.mobility(contacts.mass), less(load, branch.friction(contacts.limit)))
    turned = 0.0
    for m, v, a in zip(contacts.mass, velocity, gain, strict=True):
        turned += m * v * (v + left * a)
    rests = turned < 0
    for pulled, most in zip(along(LINES, load), contacts.along, strict=True):
        rests = rests & (jnp.abs(pulled) <= most)
    moves = mark(~rests, branch.origin)
    return Branch(
        tuple(moves * side for side in branch.side),
        tuple(moves * on for on in branch.line),
        jnp.maximum(branch.origin, 1 - moves),
    )


def _first_event(motion: Motion, contacts: Contacts) -> _Event:
    """When the motion leaves its branch, and by which contact.

    A sliding contact stops where its speed passes zero, a held one gives way where what it
    holds passes its limit. At the origin what counts is the pull along a line, against all
    the friction along it.
    """
    branch, left = motion.branch, 1 - motion.begin
    ways = branch.holding(contacts)
    times, towards = [], []
    for i, (direction, way) in enumerate(zip(DIRECTIONS, ways, strict=True)):
        side, held = branch.side[i], branch.line[i] + branch.origin
        limit = branch.line[i] * contacts.limit[i] + branch.origin * contacts.along[i]
        speed = combination(
            *zip(direction, (v.quadratic for v in motion.velocity), strict=True)
        )
        hold = combination(*zip(way, motion.pull, strict=True))
        pulled = jnp.sign(hold(left))
        reserve = combination((side, speed), (-pulled, hold))
        slack = side * speed.constant * (1 - motion.fresh[i])
        reserve = reserve._replace(constant=slack + held * limit - pulled * hold.constant)
        bend = side * weighted(direction, tuple(v.bend for v in motion.velocity))
        set_going = (held == 0) & (motion.fresh[i] != 0)
        time, _ = fall(Cubic(reserve, bend), left=left, set_going=set_going)
        times.append(time)
        towards.append(pulled)
    one, two, three = times
    first = (one < left) & (one <= two) & (one <= three)
    second = (two < left) & (two <= three) & ~first
    third = (three < left) & ~first & ~second
    passed = jnp.where(first, one, jnp.where(second, two, three))
    return _Event(
        passed,
        tuple(mark(which, passed) for which in (first, second, third)),
        tuple(towards),
    )
