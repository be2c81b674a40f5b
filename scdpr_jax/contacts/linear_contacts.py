r"""Contacts of the linear robot in a step: their assumed friction, and where they leave it.

`linear_stepping` asks them three things of a step, in this order: which friction they have on
the branch that they begin it on, what that branch holds at the step's end, and how the true
friction differs from there on.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.contacts import pulley_stick_slip, stick_slip
from scdpr_jax.contacts.pulley_stick_slip import Pair
from scdpr_jax.contacts.stick_slip import Quadratic, Scalars
from scdpr_jax.numerics.once import once

LOWER, UPPER, HEIGHT = 2, 3, 4
"""The coordinates with friction, $q_3$, $q_4$ and $y_e$."""
_PAIR = (LOWER, HEIGHT)
"""Those that share the lower carriage's and the drives' friction."""


class Tables(NamedTuple):
    """A propagator's tables as scalars, unpacked once: batched, each is an array of its own."""

    duration: Float[Array, ""]
    transition: tuple[Scalars, ...]
    responses: tuple[tuple[Scalars, ...], ...]
    pull: tuple[Scalars, ...]
    coupling: tuple[Scalars, ...]
    mass: Scalars
    damped: Scalars
    limit: Scalars
    height: tuple[Scalars, ...]
    drives: Scalars | None


class Moving(NamedTuple):
    r"""A state as scalars: $[x_e, \delta_e, q_3, q_4, y_e]$ and its derivative."""

    position: Scalars
    velocity: Scalars


class Start(NamedTuple):
    """A step's beginning and what is held through it."""

    tables: Tables
    state: Moving
    pushed: dict[int, Float[Array, ""]]
    """What drives and weight do to the coordinates with friction in the step [m/s]."""

    def load(self, i: int, at: Moving) -> Float[Array, ""]:
        """What acts on a coordinate in the step but damping and dry friction [m/s]."""
        return self._pulled(i, at.position) + self.pushed[i]

    def load_slope(self, i: int) -> Float[Array, ""]:
        """How that changes at the beginning [m/s]."""
        return self.tables.duration * self._pulled(i, self.state.velocity)

    def _pulled(self, i: int, along: Scalars) -> Float[Array, ""]:
        if i == HEIGHT:
            return jnp.zeros_like(along[i])
        row = self.tables.pull[i - LOWER]
        return sum(row[j] * along[j] for j in range(4))


class Rubbed(NamedTuple):
    """Assumed friction on a coordinate through the step, in velocity units [m/s].

    It is constant on what slides; on what is held it is the load, but for its curvature,
    which is known only at the step's end.
    """

    constant: Float[Array, ""]
    rising: Float[Array, ""]


class Departure(NamedTuple):
    """How contacts leave the branches that they begin a step on."""

    deviations: dict[int, stick_slip.Deviation]
    """By the coordinate that feels them."""
    at_rest: Callable[[Sequence[Float[Array, ""]]], dict[int, Float[Array, ""]]]
    """From velocities at the end to those by which what sticks is at rest to the bit."""


class Carriage(NamedTuple):
    """A carriage under its own friction alone, on the branch that it begins a step on."""

    start: Start
    i: int
    damped: Float[Array, ""]
    limit: Float[Array, ""]
    branch: Float[Array, ""]
    load: Float[Array, ""]
    slope: Float[Array, ""]

    def rubbed(self) -> dict[int, Rubbed]:
        """Its assumed friction."""
        rests = self.branch == 0
        steady = jnp.where(rests, self.load, self.branch * self.limit)
        return {self.i: Rubbed(steady, jnp.where(rests, self.slope, 0.0))}

    def held(self, end: Moving) -> Moving:
        """The assumed end with what the branch holds put back."""
        q, v = list(end.position), list(end.velocity)
        rests = self.branch == 0
        q[self.i] = jnp.where(rests, self.start.state.position[self.i], q[self.i])
        v[self.i] = jnp.where(rests, 0.0, v[self.i])
        return Moving(tuple(q), tuple(v))

    def departure(self, end: Moving) -> Departure:
        """Where it leaves its branch, by its motion and load as polynomials."""
        i, speed, arriving = self.i, self.start.state.velocity[self.i], end.velocity[self.i]
        rests, friction = self.branch == 0, self.branch * self.limit
        linear = jnp.where(rests, 0.0, self.load - self.damped * speed - friction)
        quadratic = arriving - speed - linear
        last = self.start.load(i, end)
        curve = once(last - self.load - self.slope)
        end_slope = last - self.damped * arriving - friction
        found = stick_slip.deviation(
            stick_slip.Assumed(
                branch=self.branch,
                velocity=Quadratic(speed, linear, quadratic),
                bend=end_slope - linear - 2 * quadratic,
                load=Quadratic(self.load, self.slope, curve),
                limit=self.limit,
                unheld=jnp.where(rests, curve, 0.0),
                stiffness=_stiffness(self.start.tables, i),
            )
        )
        return Departure(
            {i: found}, lambda velocity: {i: jnp.where(found.sticks, 0.0, velocity[i])}
        )


def carriage(start: Start, i: int) -> Carriage:
    """A carriage as a step begins.

    Args:
        start: The step's beginning.
        i: Its coordinate, `LOWER` or `UPPER`.

    Returns:
        The carriage on its branch.
    """
    damped, limit = start.tables.damped[i - LOWER], start.tables.limit[i - LOWER]
    load = start.load(i, start.state)
    branch = stick_slip.branch_at_start(start.state.velocity[i], load, limit)
    return Carriage(start, i, damped, limit, branch, load, start.load_slope(i))


def _stiffness(tables: Tables, i: int) -> Float[Array, ""]:
    """The cables' stiffness against a carriage, times the step squared over mass [1]."""
    return -tables.duration * tables.pull[i - LOWER][i]


class Pulleys(NamedTuple):
    """Lower carriage and height under the friction of the guide and of both drives."""

    start: Start
    contacts: pulley_stick_slip.Contacts
    damping: Pair
    """Viscous damping, times the step's length [kg]."""
    branch: pulley_stick_slip.Branch
    mobility: pulley_stick_slip.Three
    load: Pair
    """As the step begins, without damping [N s]."""
    slope: Pair
    """How it changes then [N s]."""
    gain: Pair
    """What is gained in a step at the beginning's acceleration [m/s]."""

    def rubbed(self) -> dict[int, Rubbed]:
        """Their assumed friction."""
        force = _less(self.load, self.damping, self._speeds(self.start.state))
        slope = _less(self.slope, self.damping, self.gain)
        turn = pulley_stick_slip.act(self.mobility, slope)
        return {
            i: Rubbed(force[n] / m - self.gain[n], slope[n] / m - turn[n])
            for n, (i, m) in enumerate(zip(_PAIR, self.contacts.mass, strict=True))
        }

    def held(self, end: Moving) -> Moving:
        """The assumed end with what the branch holds put back."""
        q, v = list(end.position), list(end.velocity)
        before = self.start.state.position
        moved = self.branch.exactly(tuple(q[i] - before[i] for i in _PAIR), self.contacts.mass)
        speeds = self.branch.exactly(self._speeds(end), self.contacts.mass)
        for i, way, speed in zip(_PAIR, moved, speeds, strict=True):
            q[i], v[i] = before[i] + way, speed
        return Moving(tuple(q), tuple(v))

    def departure(self, end: Moving) -> Departure:
        """Where they leave their branch, by their motion and load as polynomials."""
        mass = self.contacts.mass
        speeds, arriving = self._speeds(self.start.state), self._speeds(end)
        last = tuple(m * self.start.load(i, end) for i, m in zip(_PAIR, mass, strict=True))
        end_gain = _gain(
            self.branch, self.mobility, _less(last, self.damping, arriving), self.contacts
        )
        quadratic = tuple(
            b - a - g for a, b, g in zip(speeds, arriving, self.gain, strict=True)
        )
        curve = tuple(
            once(b - a - s) for a, b, s in zip(self.load, last, self.slope, strict=True)
        )
        found = pulley_stick_slip.deviation(
            pulley_stick_slip.Assumed(
                branch=self.branch,
                mobility=self.mobility,
                velocity=_quadratics(speeds, self.gain, quadratic),
                bend=tuple(
                    e - g - 2 * c
                    for e, g, c in zip(end_gain, self.gain, quadratic, strict=True)
                ),
                load=_quadratics(self.load, self.slope, curve),
                damping=self.damping,
                stiffness=mass[0] * _stiffness(self.start.tables, LOWER),
            ),
            self.contacts,
        )
        unheld = ((1 / mass[0] - self.mobility[0]) * curve[0], jnp.zeros_like(curve[1]))
        deviations = {
            i: stick_slip.deviating(moments, unheld[n], sticks=found.branch.origin != 0)
            for n, (i, moments) in enumerate(
                zip(_PAIR, zip(*found.moments, strict=True), strict=True)
            )
        }

        def at_rest(velocity: Sequence[Float[Array, ""]]) -> dict[int, Float[Array, ""]]:
            pair = tuple(velocity[i] for i in _PAIR)
            return dict(zip(_PAIR, found.branch.exactly(pair, mass), strict=True))

        return Departure(deviations, at_rest)

    def _speeds(self, at: Moving) -> Pair:
        return tuple(at.velocity[i] for i in _PAIR)


def pulleys(start: Start) -> Pulleys:
    """Lower carriage and height as a step begins.

    Args:
        start: The step's beginning, with tables that have the drives' friction.

    Returns:
        Both on their branch.
    """
    tables, (_, velocity) = start.tables, start.state
    mass = tuple(tables.mass[i - LOWER] for i in _PAIR)
    damping = tuple(m * tables.damped[i - LOWER] for i, m in zip(_PAIR, mass, strict=True))
    contacts = pulley_stick_slip.Contacts(mass, (*tables.drives, tables.limit[0] * mass[0]))
    load = tuple(m * start.load(i, start.state) for i, m in zip(_PAIR, mass, strict=True))
    slope = tuple(m * start.load_slope(i) for i, m in zip(_PAIR, mass, strict=True))
    speeds = tuple(velocity[i] for i in _PAIR)
    force = _less(load, damping, speeds)
    branch = pulley_stick_slip.branch_at_start(speeds, force, contacts)
    mobility = branch.mobility(mass)
    gain = tuple(map(once, _gain(branch, mobility, force, contacts)))
    return Pulleys(start, contacts, damping, branch, mobility, load, slope, gain)


def _gain(
    branch: pulley_stick_slip.Branch,
    mobility: pulley_stick_slip.Three,
    force: Pair,
    contacts: pulley_stick_slip.Contacts,
) -> Pair:
    """What a branch gains in a step under a force, damping included [m/s]."""
    slide = branch.friction(contacts.limit)
    return pulley_stick_slip.act(
        mobility, tuple(p - f for p, f in zip(force, slide, strict=True))
    )


def _less(load: Pair, damping: Pair, velocity: Pair) -> Pair:
    """A load less what damping takes of it."""
    return tuple(p - c * v for p, c, v in zip(load, damping, velocity, strict=True))


def _quadratics(constant: Pair, linear: Pair, quadratic: Pair) -> tuple[Quadratic, Quadratic]:
    return tuple(map(Quadratic, constant, linear, quadratic))
