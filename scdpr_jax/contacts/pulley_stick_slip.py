r"""Lower carriage and drives under set-valued dry friction within one short step.

The pulleys follow the lower carriage and the height, so that three contacts act on the
pair of velocities $v = (\dot q_3, \dot y_e)$: each has a direction c, a speed $c \cdot v$ and a
largest friction l.

$$ c_1 = (1, 1), \quad c_2 = (1, -1), \quad c_3 = (1, 0) $$

for the first and the second drive at their pulleys' rims and for the lower carriage on its
guide. Their lines of rest $c_i \cdot v = 0$ cut the plane into six sectors of sliding. On a
line one contact sticks and the pair moves along $d_i$, at the origin all three stick.

A step begins in a sector, on a line or at the origin, and a smooth integrator carries it
through there. This module follows the true motion from event to event (a contact stops,
turns round, sticks or gives way), and finds how much the true friction differs from the
assumed one.

Time runs from 0 to 1 through the step, and forces are multiplied by the step's length, so
that they are momenta [N s].
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from equinox.internal import unvmap_any
from jaxtyping import Array, Bool, Float, Int

from scdpr_jax.contacts import stick_slip
from scdpr_jax.contacts.stick_slip import Quadratic, nearer
from scdpr_jax.numerics.once import once

EVENTS = 5
"""Events of one step that are followed; after them it stays on its branch, or at rest. All
three contacts may stop in one instant, three events, and give way again in the same step."""

LEAST_TO_BEND = 1e-3
"""Share of a step in which a velocity is straight, and only roundings would bend it [1]."""

SOON = 1e-6
"""Share of the time left in a step within which contacts give way together [1]."""

Pair = tuple[Float[Array, ""], Float[Array, ""]]
"""Of the lower carriage and of the height."""
Three = tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]
"""Of the first drive, the second drive and the lower carriage."""
Quadratics = tuple[Quadratic, Quadratic]
"""Of the lower carriage and of the height, in the step's time."""

_CONTACTS = ((1, 1), (1, -1), (1, 0))
_LINES = ((1, -1), (1, 1), (0, 1))
"""The directions c and d."""


class Contacts(NamedTuple):
    """What the contacts act on, and how much they hold."""

    mass: Pair
    """Masses of both coordinates [kg]."""
    limit: Three
    """Largest frictions [N, or N s as the loads]."""

    @property
    def share(self) -> Float[Array, ""]:
        r"""$m_y / (m_3 + m_y)$: a drive that is held holds this much of $q_3$'s force."""
        return self.mass[1] / (self.mass[0] + self.mass[1])

    @property
    def along(self) -> Three:
        r"""All friction along each line, $\sum l_i |c_i \cdot d|$."""
        first, second, guide = self.limit
        return guide + 2 * second, guide + 2 * first, first + second


class Branch(NamedTuple):
    """Which contacts slide, and which way. Marks are 1 where something is so, otherwise 0."""

    side: Three
    """+1 or -1 while sliding, 0 while held."""
    line: Three
    """Marks the contact that alone is held."""
    origin: Float[Array, ""]
    """Marks that all of them are held."""

    def friction(self, limit: Three) -> Pair:
        """Friction of the contacts that slide."""
        first, second, guide = (s * own for s, own in zip(self.side, limit, strict=True))
        return first + second + guide, first - second

    def mobility(self, mass: Pair) -> Three:
        r"""What a force does to the pair while held contacts hold: $a_{33}, a_{3y}, a_{yy}$.

        $$ d d^T / (d^T M d) $$ on a line, the inverse of M in a sector, 0 at the origin.
        """
        first, second, guide = self.line
        drive = (first + second) / (mass[0] + mass[1])
        free = 1 - self.origin - first - second
        return (
            drive + (free - guide) / mass[0],
            (second - first) / (mass[0] + mass[1]),
            drive + free / mass[1],
        )

    def exactly(self, velocity: Pair, mass: Pair) -> Pair:
        """The nearest velocity at which held contacts have no speed, to the bit."""
        lower, height = velocity
        first, second, guide = (mark != 0 for mark in self.line)
        rests = self.origin != 0
        side = jnp.where(second, 1.0, -1.0)
        along = (mass[0] * lower + side * mass[1] * height) / (mass[0] + mass[1])
        return (
            jnp.where(rests | guide, 0.0, jnp.where(first | second, along, lower)),
            jnp.where(rests, 0.0, jnp.where(first | second, side * along, height)),
        )


def act(mobility: Three, force: Pair) -> Pair:
    """Accelerations of the pair under a force.

    Args:
        mobility: The branch's.
        force: All forces but those of held contacts.

    Returns:
        Both [m/s², or m/s for a momentum].
    """
    lower, height = force
    return (
        mobility[0] * lower + mobility[1] * height,
        mobility[1] * lower + mobility[2] * height,
    )


class Assumed(NamedTuple):
    """The pair's motion through the step on the branch that it began on."""

    branch: Branch
    mobility: Three
    """The branch's [1/kg]."""
    velocity: Quadratics
    """Velocities through their start, their slope there and their end [m/s]."""
    bend: Pair
    """Slopes of the velocities' ends beyond that, which makes them cubics [m/s]."""
    load: Quadratics
    """All forces but dry friction and damping [N s]."""
    damping: Pair
    """Viscous damping, times the step's length [kg]."""
    stiffness: Float[Array, ""]
    """The cables' stiffness against the lower carriage, times the step squared [kg]."""


class Deviation(NamedTuple):
    """What the true friction does to the pair beyond the assumed one."""

    moments: tuple[Pair, Pair, Pair, Pair]
    r"""$E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$, d the difference over the masses,
    up to E_3 [m/s]."""
    branch: Branch
    """The branch at the end of the step."""


class _Motion(NamedTuple):
    """The true motion from an event on, in the time since then."""

    begin: Float[Array, ""]
    branch: Branch
    fresh: Three
    """Marks contacts that were at rest at the beginning."""
    velocity: Quadratics
    load: Quadratics
    """All forces but dry friction, damping included."""
    pull: Quadratics
    """The load less the friction of what slides."""
    friction: Quadratics
    """All friction over the masses."""


class _Event(NamedTuple):
    """The first event of a motion, if it has one."""

    passed: Float[Array, ""]
    """Time since the motion's beginning; all that is left where nothing happens."""
    mark: Three
    """Marks the contact, or at the origin the one that holds on as others give way."""
    towards: Three
    """Sides to which held contacts are pulled."""


def branch_at_start(velocity: Pair, load: Pair, contacts: Contacts) -> Branch:
    """The branch on which the pair begins a step.

    Args:
        velocity: Velocities at the beginning; a contact that sticks has no speed, exactly.
        load: Forces that friction has to balance.
        contacts: The contacts, with limits in the loads' unit.

    Returns:
        The sides of what moves, and whether friction holds what doesn't.
    """
    speeds = _along(_CONTACTS, velocity)
    rests = tuple(_mark(speed == 0, speed) for speed in speeds)
    origin = rests[0] * rests[1]
    line = tuple(rest * (1 - origin) for rest in rests)
    resting = Branch(tuple(map(jnp.sign, speeds)), line, origin)
    return _once_branch(_decided(resting, load, contacts))


def deviation(assumed: Assumed, contacts: Contacts) -> Deviation:
    """Where the pair leaves its branch, and how far the friction then deviates.

    Args:
        assumed: The motion on the branch that the pair began on.
        contacts: The contacts.

    Returns:
        Moments of the deviation and the branch at the end.
    """
    velocity = tuple(_once(v) for v in assumed.velocity)
    assumed = assumed._replace(velocity=velocity)
    load = tuple(
        _once(_sum((1, p), (-c, v)))
        for p, c, v in zip(assumed.load, assumed.damping, velocity, strict=True)
    )
    none = jnp.zeros_like(velocity[0].constant)
    speeds = _along(_CONTACTS, (velocity[0].constant, velocity[1].constant))
    fresh = tuple(_mark(speed == 0, speed) for speed in speeds)
    motion = _moving(none, assumed.branch, fresh, velocity, load, assumed.mobility, contacts)

    event = _first_event(motion, contacts, assumed.bend)
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


class _Followed(NamedTuple):
    """What has been followed of a step."""

    motion: _Motion
    """The motion from the last event on."""
    event: _Event
    """The next one."""
    moments: tuple[Pair, Pair, Pair, Pair]
    """Moments of the deviation until the last one."""


def _further(
    assumed: Assumed, contacts: Contacts, order: Int[Array, ""], done: _Followed
) -> _Followed:
    """Followed beyond the next event, which is the step's event of this order, from 0."""
    # The assumed motion is a cubic until the first event, a quadratic from then on.
    bend = tuple(jnp.where(order == 0, b, 0.0) for b in assumed.bend)
    following = _after(
        assumed._replace(bend=bend),
        done.motion,
        done.event,
        contacts,
        last=order == EVENTS - 1,
    )
    change = tuple(
        _sum((1, _later(was, done.event.passed)), (-1, now))
        for was, now in zip(done.motion.friction, following.friction, strict=True)
    )
    left = 1 - following.begin
    moments = tuple(
        tuple(m + _moment(k, left, own) for m, own in zip(pair, change, strict=True))
        for k, pair in enumerate(done.moments)
    )
    end = following.branch.exactly(_end(assumed, moments, contacts), contacts.mass)
    velocity = tuple(
        _through(v, own, left) for v, own in zip(following.velocity, end, strict=True)
    )
    following = following._replace(velocity=velocity)
    event = _first_event(following, contacts, (jnp.zeros_like(left),) * 2)
    return _Followed(following, event, moments)


def _end(assumed: Assumed, moments: tuple[Pair, ...], contacts: Contacts) -> Pair:
    """Velocities at the step's end by the deviation so far."""
    couplings = (-assumed.stiffness / contacts.mass[0], 0.0)
    parts = (assumed.velocity, zip(*moments, strict=True), assumed.damping, contacts.mass)
    return tuple(
        velocity(1.0) + stick_slip.answer(own, damping / mass, coupling)[1]
        for velocity, own, damping, mass, coupling in zip(*parts, couplings, strict=True)
    )


def _through(velocity: Quadratic, end: Float[Array, ""], left: Float[Array, ""]) -> Quadratic:
    """The velocity bent to pass through the step's end, if there is time left to bend it.

    Otherwise a contact could stop just before the end and yet be on its old side there: it
    would stop once more in the next step, and derivatives would take the event twice.
    """
    short = end - velocity.constant - left * velocity.linear
    bends = left > LEAST_TO_BEND
    quadratic = short / jnp.square(jnp.where(bends, left, 1.0))
    return velocity._replace(quadratic=once(jnp.where(bends, quadratic, velocity.quadratic)))


def _anywhere(event: _Event) -> Bool[Array, ""]:
    """Whether there is an event in any run of a batch.

    Most steps have none in any of a few runs, and save the work. A run without one is the
    same to the bit where another's takes it along: all that changes is over no time.
    """
    return unvmap_any(sum(event.mark) > 0)


def _moving(
    begin: Float[Array, ""],
    branch: Branch,
    fresh: Three,
    velocity: Quadratics,
    load: Quadratics,
    mobility: Three,
    contacts: Contacts,
) -> _Motion:
    slide = branch.friction(contacts.limit)
    pull = tuple(p._replace(constant=p.constant - f) for p, f in zip(load, slide, strict=True))
    # What is held takes what its contact leaves of the pull, over the masses.
    lower, across, height = mobility
    own = (1 / contacts.mass[0] - lower, 1 / contacts.mass[1] - height)
    friction = []
    for i in range(2):
        held = _sum((own[i], pull[i]), (-across, pull[1 - i]))
        friction.append(held._replace(constant=held.constant + slide[i] / contacts.mass[i]))
    return _Motion(begin, branch, fresh, velocity, load, pull, tuple(friction))


def _after(
    assumed: Assumed,
    motion: _Motion,
    event: _Event,
    contacts: Contacts,
    *,
    last: Bool[Array, ""],
) -> _Motion:
    """The motion after its first event, the last of the step that is followed or not."""
    was, mark, passed = motion.branch, event.mark, event.passed
    begin = once(motion.begin + passed)
    happens = sum(mark)
    on_line = sum(was.line)
    gives_way = sum(e * on for e, on in zip(mark, was.line, strict=True))
    # Along a line everything stops at once; out of a sector a contact stops alone.
    stops = on_line * (happens - gives_way)
    alone = tuple(e * (1 - on_line - was.origin) for e in mark)

    arrived = tuple(v(passed) for v in motion.velocity)
    bent = jnp.square(passed) * (passed - 1)
    arrived = tuple(v + b * bent for v, b in zip(arrived, assumed.bend, strict=True))
    velocity = _stopped(arrived, alone, 1 - stops - was.origin, contacts)
    load = tuple(
        once(p(passed) + c * (v - now))
        for p, c, v, now in zip(motion.load, assumed.damping, arrived, velocity, strict=True)
    )

    sides = tuple(s * (1 - e) * (1 - stops) for s, e in zip(was.side, mark, strict=True))
    settled = _decided(Branch(sides, alone, stops), load, contacts)
    given_way = _given_way(was, event, happens=happens, gives_way=gives_way)
    # From the origin contacts may give way together: which, the load tells a little later.
    soon = passed + SOON * (1 - begin)
    left_at_once = _decided(was, tuple(p(soon) for p in motion.load), contacts)
    together = happens * was.origin * (1 - left_at_once.origin) != 0
    given_way = _chosen(together, left_at_once, given_way)
    settles = happens * (1 - was.origin) - gives_way != 0
    branch = _once_branch(_chosen(settles, settled, given_way))
    rested = _rests_if_it_turns(branch, velocity, load, happens * (1 - begin), contacts)
    branch = _chosen(last, rested, branch)
    fresh = tuple(jnp.minimum(e + stops + was.origin, 1.0) for e in mark)
    return _onwards(assumed, begin, branch, fresh, velocity, load, contacts)


def _given_way(
    was: Branch, event: _Event, *, happens: Float[Array, ""], gives_way: Float[Array, ""]
) -> Branch:
    """The branch after held contacts gave way, each to the side to which it was pulled.

    From the origin the pair leaves along the line of the marked contact, which holds on.
    """
    leaves = happens * was.origin
    towards = sum(e * t for e, t in zip(event.mark, event.towards, strict=True))
    out = _sides_of_line(event.mark, leaves * towards)
    return Branch(
        tuple(
            s + e * gives_way * towards + o
            for s, e, o in zip(was.side, event.mark, out, strict=True)
        ),
        tuple(
            on * (1 - gives_way) + leaves * e
            for on, e in zip(was.line, event.mark, strict=True)
        ),
        was.origin - leaves,
    )


def _onwards(
    assumed: Assumed,
    begin: Float[Array, ""],
    branch: Branch,
    fresh: Three,
    velocity: Pair,
    load: Pair,
    contacts: Contacts,
) -> _Motion:
    """The motion on a branch from an instant on, as the loads go on from there."""
    mobility = branch.mobility(contacts.mass)
    sliding = branch.friction(contacts.limit)
    pull = tuple(p - f for p, f in zip(load, sliding, strict=True))
    gain = tuple(map(once, act(mobility, pull)))
    lower, height = (
        _later(p, begin).linear - c * a
        for p, c, a in zip(assumed.load, assumed.damping, gain, strict=True)
    )
    # The cables feel how far the carriage strays from the assumed motion.
    assumed_velocity = _later(assumed.velocity[0], begin)
    strayed = assumed.stiffness * (velocity[0] - assumed_velocity.constant)
    straying = assumed.stiffness * (gain[0] - assumed_velocity.linear)
    linear = (once(lower - strayed), once(height))
    quadratic = (assumed.load[0].quadratic - straying / 2, assumed.load[1].quadratic)
    bending = tuple(map(once, act(mobility, linear)))
    return _moving(
        begin,
        branch,
        fresh,
        tuple(Quadratic(v, a, j / 2) for v, a, j in zip(velocity, gain, bending, strict=True)),
        tuple(Quadratic(*parts) for parts in zip(load, linear, quadratic, strict=True)),
        mobility,
        contacts,
    )


def _rests_if_it_turns(
    branch: Branch,
    velocity: Pair,
    load: Pair,
    left: Float[Array, ""],
    contacts: Contacts,
) -> Branch:
    """The branch after the last event that is followed: at rest, if it stops before the end.

    What zigzags to rest in more events than are followed would pass it otherwise, and turn
    round in every step from then on.
    """
    sliding = branch.friction(contacts.limit)
    pull = tuple(p - f for p, f in zip(load, sliding, strict=True))
    gain = act(branch.mobility(contacts.mass), pull)
    turned = 0.0
    for m, v, a in zip(contacts.mass, velocity, gain, strict=True):
        turned += m * v * (v + left * a)
    rests = turned < 0
    for pulled, own in zip(_along(_LINES, load), contacts.along, strict=True):
        rests = rests & (jnp.abs(pulled) <= own)
    moves = once(_mark(~rests, branch.origin))
    return Branch(
        tuple(once(moves * side) for side in branch.side),
        tuple(once(moves * on) for on in branch.line),
        once(jnp.maximum(branch.origin, 1 - moves)),
    )


def _first_event(motion: _Motion, contacts: Contacts, bend: Pair) -> _Event:
    """When the motion leaves its branch, and by which contact.

    A sliding contact stops where its speed passes zero, a held one gives way where what it
    holds passes its limit. At the origin what counts is the pull along a line, against all
    the friction along it.
    """
    branch, left = motion.branch, 1 - motion.begin
    speeds = [_sum(*zip(c, motion.velocity, strict=True)) for c in _CONTACTS]
    times, towards = [], []
    for i, (speed, way) in enumerate(zip(speeds, _ways(branch, contacts), strict=True)):
        side, held = branch.side[i], branch.line[i] + branch.origin
        limit = branch.line[i] * contacts.limit[i] + branch.origin * contacts.along[i]
        hold = _sum(*zip(way, motion.pull, strict=True))
        pulled = once(jnp.sign(hold(left)))
        reserve = _sum((side, speed), (-pulled, hold))
        slack = side * speed.constant * (1 - motion.fresh[i])
        reserve = reserve._replace(constant=slack + held * limit - pulled * hold.constant)
        bent = side * (_CONTACTS[i][0] * bend[0] + _CONTACTS[i][1] * bend[1])
        set_going = (held == 0) & (motion.fresh[i] != 0)
        times.append(once(_falls(reserve, set_going, left, bent)))
        towards.append(pulled)
    one, two, three = times
    first = (one < left) & (one <= two) & (one <= three)
    second = (two < left) & (two <= three) & ~first
    third = (three < left) & ~first & ~second
    passed = once(jnp.where(first, one, jnp.where(second, two, three)))
    mark = tuple(once(_mark(which, passed)) for which in (first, second, third))
    return _Event(passed, mark, tuple(towards))


def _falls(
    reserve: Quadratic,
    set_going: Bool[Array, ""],
    left: Float[Array, ""],
    bend: Float[Array, ""],
) -> Float[Array, ""]:
    """When a reserve falls below zero first; all the time that is left if it doesn't.

    What rises from zero turns back at its other zero. Of a contact that has just been set
    going only roundings could say that it stops at once; of another one that stands as it
    falls, because several stop together, it is so.
    """
    constant, linear, quadratic = reserve
    discriminant = jnp.square(linear) - 4 * quadratic * constant
    real = discriminant > 0
    root = jnp.sqrt(jnp.where(real, discriminant, 1.0))
    rises = linear > 0
    found = real & jnp.where(rises, quadratic < 0, ~set_going)
    above = jnp.where(rises, -linear - root, 2 * constant)
    below = jnp.where(rises, 2 * quadratic, root - linear)
    found = found & (below != 0)
    time = jnp.maximum(above / jnp.where(found, below, 1.0), 0.0)
    time = jnp.where(found & (time < left), time, left)
    return jnp.where(time < left, nearer(reserve, bend, time), time)


def _ways(branch: Branch, contacts: Contacts) -> tuple[Pair, Pair, Pair]:
    """Along what the pull counts for each contact that is held; nothing for the others."""
    first, second, guide = branch.line
    share, origin = contacts.share, branch.origin
    return (
        (first * share + origin, first * (1 - share) - origin),
        (second * share + origin, origin - second * (1 - share)),
        (guide, origin),
    )


def _decided(resting: Branch, load: Pair, contacts: Contacts) -> Branch:
    r"""What contacts at rest do under a load: hold, or slide to either side.

    From the origin the pair leaves along the line down which the power is greatest,
    $(|F \cdot d| - \sum l_i |c_i \cdot d|)^2 / (d^T M d)$, or to a side of it. There lies
    the acceleration of least $a^T M a / 2 - F \cdot a + \sum l_i |c_i \cdot a|$: the lines
    beside it are the lowest of all.

    Args:
        resting: Contacts that move, and those at rest as if they were held.
        load: What acts on the pair but dry friction.
        contacts: The contacts.
    """
    origin = resting.origin
    pulls, friction = _along(_LINES, load), contacts.along
    total = contacts.mass[0] + contacts.mass[1]
    scores = []
    for pull, own, mass in zip(pulls, friction, (total, total, contacts.mass[1]), strict=True):
        excess = jnp.abs(pull) - own
        # Nothing is held where there is no friction.
        leaves = (excess > 0) | (own == 0)
        scores.append(jnp.where(leaves, jnp.square(excess) / mass, -1.0))
    first, second, guide = scores
    by_guide = (guide >= first) & (guide >= second)
    by_first = ~by_guide & (first >= second)
    by_second = ~(by_guide | by_first)
    best = tuple(once(_mark(b, first) * origin) for b in (by_first, by_second, by_guide))
    stays = once(origin * _mark(jnp.maximum(jnp.maximum(first, second), guide) < 0, first))

    towards = jnp.sign(sum(b * pull for b, pull in zip(best, pulls, strict=True)))
    out = _sides_of_line(best, origin * towards)
    side = tuple(s + o for s, o in zip(resting.side, out, strict=True))
    line = tuple(on + b for on, b in zip(resting.line, best, strict=True))
    gone = Branch(side, line, jnp.zeros_like(origin))
    pull = tuple(p - f for p, f in zip(load, gone.friction(contacts.limit), strict=True))
    held = sum(_dot(way, pull) for way in _ways(gone, contacts))
    own = sum(on * limit for on, limit in zip(line, contacts.limit, strict=True))
    held = once(held)
    sticks = once(_mark((jnp.abs(held) <= own) & (own > 0), own))
    slides = (1 - sticks) * jnp.sign(held)
    return Branch(
        tuple((1 - stays) * (s + slides * on) for s, on in zip(side, line, strict=True)),
        tuple((1 - stays) * sticks * on for on in line),
        stays,
    )


def _stopped(
    velocity: Pair,
    alone: Three,
    moves: Float[Array, ""],
    contacts: Contacts,
) -> Pair:
    """The nearest velocity at which a contact has stopped, or nothing moves."""
    first, second, guide = (
        on * s for on, s in zip(alone, _along(_CONTACTS, velocity), strict=True)
    )
    lower, height = velocity
    share = contacts.share
    return (
        once(moves * (lower - share * (first + second) - guide)),
        once(moves * (height - (1 - share) * (first - second))),
    )


def _sides_of_line(line: Three, towards: Float[Array, ""]) -> Three:
    """Sides of the contacts where the pair moves along a line, to its end or back."""
    first, second, guide = line
    return (
        towards * (second + guide),
        towards * (first - guide),
        towards * (first + second),
    )


def _along(directions: tuple[tuple[int, int], ...], pair: Pair) -> Three:
    return tuple(a * pair[0] + b * pair[1] for a, b in directions)


def _dot(one: Pair, other: Pair) -> Float[Array, ""]:
    return one[0] * other[0] + one[1] * other[1]


def _mark(condition: Bool[Array, ""], like: Float[Array, ""]) -> Float[Array, ""]:
    return jnp.where(condition, jnp.ones_like(like), 0.0)


def _chosen(condition: Bool[Array, ""], one: Branch, other: Branch) -> Branch:
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), one, other)


def _sum(*terms: tuple[Float[Array, ""] | int, Quadratic]) -> Quadratic:
    """A sum of polynomials with their weights."""
    weighted = [term for term in terms if not isinstance(term[0], int) or term[0]]
    return Quadratic(
        *(sum(weight * polynomial[n] for weight, polynomial in weighted) for n in range(3))
    )


def _once(polynomial: Quadratic) -> Quadratic:
    return Quadratic(*map(once, polynomial))


def _once_branch(branch: Branch) -> Branch:
    return Branch(
        tuple(map(once, branch.side)), tuple(map(once, branch.line)), once(branch.origin)
    )


def _later(polynomial: Quadratic, time: Float[Array, ""]) -> Quadratic:
    """The polynomial in the time since an instant."""
    _, linear, quadratic = polynomial
    return Quadratic(polynomial(time), linear + 2 * time * quadratic, quadratic)


def _moment(order: int, left: Float[Array, ""], change: Quadratic) -> Float[Array, ""]:
    r"""$\int (1-\theta)^k p(\theta)\,d\theta$ over the time left, k the order.

    With p in the time since the instant, $\int_0^u (u-\tau)^k \tau^n d\tau
    = u^{k+n+1} k!\,n!/(k+n+1)!$.
    """
    constant, linear, quadratic = change
    k = order + 1
    return left**k * (
        constant / k
        + left * linear / (k * (k + 1))
        + jnp.square(left) * 2 * quadratic / (k * (k + 1) * (k + 2))
    )
