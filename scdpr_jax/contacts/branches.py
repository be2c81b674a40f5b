r"""The branches of three contacts on two coordinates: lower carriage, height and both drives.

The pulleys follow the lower carriage and the height, so that three contacts act on the pair of
velocities $v = (\dot q_3, \dot y_e)$: the drives at their pulleys' rims and the lower carriage
on its guide. Each has a direction c, a speed $c \cdot v$ and a largest friction l. The lines
of rest $c \cdot v = 0$ cut the plane into six sectors of sliding:

```
      drive 1 held   guide held   drive 2 held
               \         |         /
                 \   2   |   1   /            contact   c         line d, along
                   \     |     /                                  which the pair moves
                     \   |   /                drive 1   (1,  1)   (1, -1)
                3      \ | /      0           drive 2   (1, -1)   (1,  1)
                         o    -> q3           guide     (1,  0)   (0,  1)
                       / | \
                     /   |   \
                   /  4  |  5  \

            0   0|1   1   1|2   2   2|3   3   3|4   4   4|5   5   5|0   o
  drive 1   +    +    +    +    +    0    -    -    -    -    -    0    0
  drive 2   +    0    -    -    -    -    -    0    +    +    +    +    0
  guide     +    +    +    0    -    -    -    -    -    0    +    +    0
```

In a sector all slide (+ or -), on a half-line one is held (0) and the pair moves along its
line, at the origin o all are held. All of this follows from the directions: the side of a
contact on another's half-line is the sign of $c_i \cdot d_j$, what its friction takes along it
$l_i |c_i \cdot d_j|$.

A `Branch` keeps that as three sides and marks instead of a row's number: a table would be
looked up once for each run of a batch, where numbers are multiplied side by side.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.robot.state import HEIGHT, LOWER

PAIR = (LOWER, HEIGHT)
"""The coordinates that share the lower carriage's and the drives' friction."""

Pair = tuple[Float[Array, ""], Float[Array, ""]]
"""Of the lower carriage and of the height."""
Three = tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]
"""Of the first drive, the second drive and the lower carriage on its guide."""

DIRECTIONS = ((1, 1), (1, -1), (1, 0))
"""The directions c of the contacts."""
LINES = ((1, -1), (1, 1), (0, 1))
"""The directions d in which the pair moves while one of them is held."""
_CROSSINGS = tuple(tuple(c * d + e * f for c, e in DIRECTIONS) for d, f in LINES)
r"""$c_i \cdot d_j$, a line a row."""


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
        return tuple(weighted(tuple(map(abs, row)), self.limit) for row in _CROSSINGS)

    @property
    def inertia(self) -> Three:
        """What is moved along each line, $d^T M d$ [kg]."""
        total = self.mass[0] + self.mass[1]
        return total, total, self.mass[1]


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
        sliding = [side * most for side, most in zip(self.side, limit, strict=True)]
        return tuple(weighted(column, sliding) for column in zip(*DIRECTIONS, strict=True))

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

    def holding(self, contacts: Contacts) -> tuple[Pair, Pair, Pair]:
        """Along what a force counts for each contact that is held; nothing for the others.

        On a line it is what the contact takes of the force, at the origin the force along the
        line on which its contact would hold on.
        """
        first, second, guide = self.line
        share, origin = contacts.share, self.origin
        return (
            (first * share + origin, first * (1 - share) - origin),
            (second * share + origin, origin - second * (1 - share)),
            (guide, origin),
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

    def stopped(self, velocity: Pair, contacts: Contacts) -> Pair:
        """The velocity at which what is held here has lost its speed by its own impulse."""
        lower, height = velocity
        speeds = along(DIRECTIONS, velocity)
        first, second, guide = (m * s for m, s in zip(self.line, speeds, strict=True))
        share, moves = contacts.share, 1 - self.origin
        return (
            moves * (lower - share * (first + second) - guide),
            moves * (height - (1 - share) * (first - second)),
        )


def branch_at_start(velocity: Pair, load: Pair, contacts: Contacts) -> Branch:
    """The branch on which the pair begins a step.

    Args:
        velocity: Velocities at the beginning; a contact that sticks has no speed, exactly.
        load: Forces that friction has to balance.
        contacts: The contacts, with limits in the loads' unit.

    Returns:
        The sides of what moves, and whether friction holds what doesn't.
    """
    speeds = along(DIRECTIONS, velocity)
    rests = tuple(mark(speed == 0, speed) for speed in speeds)
    origin = rests[0] * rests[1]
    line = tuple(rest * (1 - origin) for rest in rests)
    resting = Branch(tuple(map(jnp.sign, speeds)), line, origin)
    return decided(resting, load, contacts)


def decided(resting: Branch, load: Pair, contacts: Contacts) -> Branch:
    r"""What contacts at rest do under a load: hold, or slide to either side.

    From the origin the pair leaves along the line down which the power is greatest,
    $(|F \cdot d| - \sum l_i |c_i \cdot d|)^2 / (d^T M d)$, or to a side of it. There lies
    the acceleration of least $a^T M a / 2 - F \cdot a + \sum l_i |c_i \cdot a|$: the lines
    beside it are the lowest of all.

    Args:
        resting: Contacts that move, and those at rest as if they were held.
        load: What acts on the pair but dry friction.
        contacts: The contacts.

    Returns:
        The branch.
    """
    origin = resting.origin
    pulls = along(LINES, load)
    best, stays = _leaving(pulls, contacts)
    best = tuple(chosen * origin for chosen in best)
    stays = origin * stays

    towards = jnp.sign(sum(b * pull for b, pull in zip(best, pulls, strict=True)))
    out = _sides_on_line(best, origin * towards)
    line = tuple(on + b for on, b in zip(resting.line, best, strict=True))
    gone = Branch(
        tuple(s + o for s, o in zip(resting.side, out, strict=True)),
        line,
        jnp.zeros_like(origin),
    )
    pull = less(load, gone.friction(contacts.limit))
    held = sum(h * pull[0] + k * pull[1] for h, k in gone.holding(contacts))
    most = sum(on * limit for on, limit in zip(line, contacts.limit, strict=True))
    sticks = mark((jnp.abs(held) <= most) & (most > 0), most)
    slides = (1 - sticks) * jnp.sign(held)
    return Branch(
        tuple((1 - stays) * (s + slides * on) for s, on in zip(gone.side, line, strict=True)),
        tuple((1 - stays) * sticks * on for on in line),
        stays,
    )


def _leaving(pulls: Three, contacts: Contacts) -> tuple[Three, Float[Array, ""]]:
    """Marks of the line along which the pair leaves the origin, and of its staying there."""
    scores = []
    for pull, friction, mass in zip(pulls, contacts.along, contacts.inertia, strict=True):
        excess = jnp.abs(pull) - friction
        # Nothing is held where there is no friction.
        leaves = (excess > 0) | (friction == 0)
        scores.append(jnp.where(leaves, jnp.square(excess) / mass, -1.0))
    first, second, guide = scores
    by_guide = (guide >= first) & (guide >= second)
    by_first = ~by_guide & (first >= second)
    by_second = ~(by_guide | by_first)
    best = tuple(mark(by, first) for by in (by_first, by_second, by_guide))
    return best, mark(jnp.maximum(jnp.maximum(first, second), guide) < 0, first)


def _sides_on_line(line: Three, towards: Float[Array, ""]) -> Three:
    """Sides of the contacts where the pair moves along a line, to its end or back."""
    signs = ([(c > 0) - (c < 0) for c in column] for column in zip(*_CROSSINGS, strict=True))
    return tuple(towards * weighted(column, line) for column in signs)


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


def along(directions: tuple[tuple[int, int], ...], pair: Pair) -> Three:
    """A pair's parts in three directions.

    Args:
        directions: `DIRECTIONS` or `LINES`.
        pair: Velocities or forces.

    Returns:
        Its scalar product with each.
    """
    return tuple(weighted(direction, pair) for direction in directions)


def less(load: Pair, taken: Pair) -> Pair:
    """A load less what is taken of it.

    Args:
        load: The load [N, or N s].
        taken: What damping or friction takes of it.

    Returns:
        What is left.
    """
    return load[0] - taken[0], load[1] - taken[1]


def mark(condition: Bool[Array, ""], like: Float[Array, ""]) -> Float[Array, ""]:
    """1 where something is so, otherwise 0, in a number's precision.

    Args:
        condition: What may be so.
        like: The number.

    Returns:
        The mark.
    """
    return jnp.where(condition, jnp.ones_like(like), 0.0)


def weighted(weights: Sequence[int], values: Sequence[Float[Array, ""]]) -> Float[Array, ""]:
    """A sum with whole weights, one of which at least isn't zero.

    Args:
        weights: The weights.
        values: What they weigh.

    Returns:
        The sum.
    """
    first, *others = (v if w == 1 else w * v for w, v in zip(weights, values, strict=True) if w)
    return sum(others, start=first)
