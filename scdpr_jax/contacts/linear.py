r"""Contacts of the linear robot in a step: their assumed friction, and where they leave it.

`linear_stepping` asks them three things of a step, in this order: which friction they have on
the branch that they begin it on, what that branch holds at the step's end, and how the true
friction differs from there on.

Between events the step is exact, but for one thing: what holds a contact follows the load,
which bends with the whole robot. It is taken as a straight line from the step's beginning, and
what that lacks is put back by its moments. To solve for the held robot exactly would need a
transition matrix for each of the contacts' branches.
"""

from typing import NamedTuple, Protocol

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.contacts import branches, events, single
from scdpr_jax.contacts.branches import PAIR, Pair, act, less
from scdpr_jax.contacts.motion import Assumed
from scdpr_jax.contacts.polynomial import Quadratic, cubic_between
from scdpr_jax.contacts.response import Departure, Response
from scdpr_jax.robot.state import HEIGHT, LOWER, State, with_coordinates


class Tables(Protocol):
    """What contacts need of `scdpr_jax.engines.propagator.Propagator`."""

    duration: Float[Array, ""]
    pull: Float[Array, "2 4"]
    coupling: Float[Array, "2 4"]
    mass: Float[Array, "3"]
    damped: Float[Array, "3"]
    limit: Float[Array, "2"]
    drives: Float[Array, "2"] | None


class Start(NamedTuple):
    """A step's beginning and what is held through it."""

    tables: Tables
    state: State
    pushes: dict[int, Float[Array, ""]]
    """What drives and weight do to the coordinates with friction in the step [m/s]."""

    def load(self, i: int, at: State) -> Float[Array, ""]:
        """What acts on a coordinate in the step but damping and dry friction [m/s]."""
        return self._pulled(i, at.position) + self.pushes[i]

    def load_slope(self, i: int) -> Float[Array, ""]:
        """How that changes at the beginning [m/s]."""
        return self.tables.duration * self._pulled(i, self.state.velocity)

    def response(self, i: int) -> Response:
        """How the robot answers a coordinate with friction."""
        none = jnp.zeros_like(self.state.position)
        # The height is tied to nothing near an aligned pose.
        tied = none if i == HEIGHT else jnp.append(self.tables.coupling[i - LOWER], none[0])
        return Response(self.tables.damped[i - LOWER], tied)

    def _pulled(self, i: int, along: Float[Array, "5"]) -> Float[Array, ""]:
        if i == HEIGHT:
            return jnp.zeros_like(along[i])
        return self.tables.pull[i - LOWER] @ along[:HEIGHT]


class AssumedFriction(NamedTuple):
    """Assumed friction on a coordinate through the step, in velocity units [m/s].

    It is constant on what slides; on what is held it is the load, but for its curvature,
    which is known only at the step's end.
    """

    constant: Float[Array, ""]
    rising: Float[Array, ""]


class Carriage(NamedTuple):
    """A carriage under its own friction alone, on the branch that it begins a step on."""

    start: Start
    i: int
    damped: Float[Array, ""]
    limit: Float[Array, ""]
    branch: Float[Array, ""]
    load: Float[Array, ""]
    slope: Float[Array, ""]

    def friction(self) -> dict[int, AssumedFriction]:
        """Its assumed friction."""
        rests = self.branch == 0
        steady = jnp.where(rests, self.load, self.branch * self.limit)
        return {self.i: AssumedFriction(steady, jnp.where(rests, self.slope, 0.0))}

    def held(self, end: State) -> State:
        """The assumed end with what the branch holds put back."""
        rests, before = self.branch == 0, self.start.state.position[self.i]
        position = jnp.where(rests, before, end.position[self.i])
        velocity = jnp.where(rests, 0.0, end.velocity[self.i])
        return State(
            with_coordinates(end.position, {self.i: position}),
            with_coordinates(end.velocity, {self.i: velocity}),
        )

    def departure(self, end: State) -> Departure:
        """Where it leaves its branch, by its motion and load as polynomials."""
        i, speed, arriving = self.i, self.start.state.velocity[self.i], end.velocity[self.i]
        rests, friction = self.branch == 0, self.branch * self.limit
        last = self.start.load(i, end)
        curve = last - self.load - self.slope
        deviation = single.deviation(
            single.Assumed(
                branch=self.branch,
                velocity=cubic_between(
                    speed,
                    arriving,
                    slope=jnp.where(rests, 0.0, self.load - self.damped * speed - friction),
                    end_slope=last - self.damped * arriving - friction,
                ),
                load=Quadratic(self.load, self.slope, curve),
                limit=self.limit,
                stiffness=-self.start.response(i).coupling[i],
            )
        )
        return deviation.departure(i, jnp.where(rests, curve, 0.0))


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
    branch = single.branch_at_start(start.state.velocity[i], load, limit)
    return Carriage(start, i, damped, limit, branch, load, start.load_slope(i))


class Pulleys(NamedTuple):
    """Lower carriage and height under the friction of the guide and of both drives."""

    start: Start
    contacts: branches.Contacts
    damping: Pair
    """Viscous damping, times the step's length [kg]."""
    branch: branches.Branch
    mobility: branches.Three
    load: Pair
    """As the step begins, without damping [N s]."""
    slope: Pair
    """How it changes then [N s]."""
    gain: Pair
    """What is gained in a step at the beginning's acceleration [m/s]."""

    def friction(self) -> dict[int, AssumedFriction]:
        """Their assumed friction."""
        force = _damped(self.load, self.damping, _speeds(self.start.state))
        slope = _damped(self.slope, self.damping, self.gain)
        turn = act(self.mobility, slope)
        return {
            i: AssumedFriction(force[n] / m - self.gain[n], slope[n] / m - turn[n])
            for n, (i, m) in enumerate(zip(PAIR, self.contacts.mass, strict=True))
        }

    def held(self, end: State) -> State:
        """The assumed end with what the branch holds put back."""
        before, mass = self.start.state.position, self.contacts.mass
        moved = self.branch.exactly(tuple(end.position[i] - before[i] for i in PAIR), mass)
        speeds = self.branch.exactly(_speeds(end), mass)
        places = (before[i] + way for i, way in zip(PAIR, moved, strict=True))
        return State(
            with_coordinates(end.position, dict(zip(PAIR, places, strict=True))),
            with_coordinates(end.velocity, dict(zip(PAIR, speeds, strict=True))),
        )

    def departure(self, end: State) -> Departure:
        """Where they leave their branch, by their motion and load as polynomials."""
        mass, speeds, arriving = self.contacts.mass, _speeds(self.start.state), _speeds(end)
        last = tuple(m * self.start.load(i, end) for i, m in zip(PAIR, mass, strict=True))
        end_gain = _gain(
            self.branch, self.mobility, _damped(last, self.damping, arriving), self.contacts
        )
        curve = tuple(b - a - s for a, b, s in zip(self.load, last, self.slope, strict=True))
        deviation = events.deviation(
            Assumed(
                branch=self.branch,
                mobility=self.mobility,
                velocity=tuple(
                    cubic_between(v, e, slope=g, end_slope=h)
                    for v, e, g, h in zip(speeds, arriving, self.gain, end_gain, strict=True)
                ),
                load=tuple(map(Quadratic, self.load, self.slope, curve)),
                damping=self.damping,
                stiffness=-mass[0] * self.start.response(LOWER).coupling[LOWER],
            ),
            self.contacts,
        )
        unheld = ((1 / mass[0] - self.mobility[0]) * curve[0], jnp.zeros_like(curve[1]))
        return deviation.departure(mass, unheld)


def pulleys(start: Start) -> Pulleys:
    """Lower carriage and height as a step begins.

    Args:
        start: The step's beginning, with tables that have the drives' friction.

    Returns:
        Both on their branch.
    """
    tables, speeds = start.tables, _speeds(start.state)
    mass = tuple(tables.mass[i - LOWER] for i in PAIR)
    damping = tuple(m * tables.damped[i - LOWER] for i, m in zip(PAIR, mass, strict=True))
    contacts = branches.Contacts(mass, (*tables.drives, tables.limit[0] * mass[0]))
    load = tuple(m * start.load(i, start.state) for i, m in zip(PAIR, mass, strict=True))
    slope = tuple(m * start.load_slope(i) for i, m in zip(PAIR, mass, strict=True))
    force = _damped(load, damping, speeds)
    branch = branches.branch_at_start(speeds, force, contacts)
    mobility = branch.mobility(mass)
    gain = _gain(branch, mobility, force, contacts)
    return Pulleys(start, contacts, damping, branch, mobility, load, slope, gain)


def _speeds(at: State) -> Pair:
    return tuple(at.velocity[i] for i in PAIR)


def _gain(
    branch: branches.Branch,
    mobility: branches.Three,
    force: Pair,
    contacts: branches.Contacts,
) -> Pair:
    """What a branch gains in a step under a force, damping included [m/s]."""
    return act(mobility, less(force, branch.friction(contacts.limit)))


def _damped(load: Pair, damping: Pair, velocity: Pair) -> Pair:
    """A load less what damping takes of it."""
    return less(load, tuple(c * v for c, v in zip(damping, velocity, strict=True)))
