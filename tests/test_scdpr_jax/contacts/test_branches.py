"""The thirteen branches of three contacts on two coordinates, and what contacts at rest do."""

import dataclasses
import types

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Held, _set_going
from robot_numbers import numbers_of

from scdpr_jax.contacts import branches
from scdpr_jax.contacts.branches import DIRECTIONS, LINES, Branch, Contacts, branch_at_start
from scdpr_jax.robot.prototype import consistent

MASS = (6.0, 7.0)
LIMIT = (0.3, 0.5, 0.4)

SECTORS = {(1, 0), (1, 2), (-1, 2), (-1, 0), (-1, -2), (1, -2)}
HALF_LINES = {(a * sign, b * sign) for a, b in LINES for sign in (1, -1)}


def contacts(limit=LIMIT, mass=MASS):
    return Contacts(*(tuple(map(jnp.asarray, part)) for part in (mass, limit)))


def numbers(values):
    return tuple(jnp.asarray(float(value)) for value in values)


def branch_along(velocity):
    """The branch on which the pair moves with a velocity."""
    sides = np.sign(np.array(DIRECTIONS) @ velocity)
    held = sides == 0
    origin = held.all()
    return Branch(numbers(sides), numbers(held & ~origin), jnp.asarray(float(origin)))


def flat(branch):
    return np.array([*branch.side, *branch.line, branch.origin], float)


started = jax.jit(branch_at_start)


@pytest.mark.parametrize("velocity", sorted(SECTORS | HALF_LINES))
def test_a_pair_in_motion_begins_on_the_branch_of_its_velocity(velocity):
    # Without a load, what is held stays so.
    found = started(numbers(velocity), numbers((0, 0)), contacts())
    np.testing.assert_array_equal(flat(found), flat(branch_along(velocity)))


def test_the_drawing_has_a_column_for_every_branch():
    rows = [line.split()[-13:] for line in branches.__doc__.splitlines() if line.count("+") > 2]
    sign = {"+": 1, "0": 0, "-": -1}
    drawn = {tuple(sign[c] for c in column) for column in zip(*rows, strict=True)}
    moving = {tuple(np.sign(np.array(DIRECTIONS) @ v)) for v in SECTORS | HALF_LINES}
    assert drawn == moving | {(0, 0, 0)}


@pytest.mark.parametrize("velocity", sorted(SECTORS | HALF_LINES | {(0, 0)}))
def test_a_branch_moves_under_a_force_as_its_held_contacts_let_it(velocity):
    lower, across, height = branch_along(velocity).mobility(numbers(MASS))
    mass = np.diag(MASS)
    free = {0: lambda: np.linalg.inv(mass), 3: lambda: np.zeros((2, 2))}
    held = [d for c, d in zip(DIRECTIONS, LINES, strict=True) if np.dot(c, velocity) == 0]

    def along():
        d = np.array(held[0])
        return np.outer(d, d) / (d @ mass @ d)

    expected = free.get(len(held), along)()
    found = np.array([[lower, across], [across, height]])
    np.testing.assert_allclose(found, expected, rtol=0, atol=4 * np.finfo(float).eps)


@pytest.mark.parametrize("velocity", sorted(SECTORS | HALF_LINES))
def test_friction_takes_the_power_of_every_contact_that_slides(velocity):
    friction = np.array(branch_along(velocity).friction(numbers(LIMIT)))
    power = np.abs(np.array(DIRECTIONS) @ velocity) @ LIMIT
    assert friction @ velocity == pytest.approx(power, rel=1e-15)


@pytest.mark.parametrize("velocity", sorted(HALF_LINES))
def test_friction_along_a_line_is_that_of_the_others(velocity):
    friction = np.array(branch_along(velocity).friction(numbers(LIMIT)))
    line = next(i for i, c in enumerate(DIRECTIONS) if np.dot(c, velocity) == 0)
    assert float(contacts().along[line]) == pytest.approx(friction @ velocity, rel=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_a_contact_that_stops_gets_an_impulse_in_its_own_direction(seed):
    velocity = np.random.default_rng(seed).normal(size=2)
    for i, direction in enumerate(DIRECTIONS):
        alone = branch_along(LINES[i])._replace(side=numbers((0, 0, 0)))
        stopped = np.array(alone.stopped(numbers(velocity), contacts()))
        impulse = np.array(MASS) * (stopped - velocity)
        assert abs(np.dot(direction, stopped)) <= 4 * np.finfo(float).eps
        assert (
            abs(impulse[0] * direction[1] - impulse[1] * direction[0])
            <= 64 * np.finfo(float).eps
        )
        exactly = np.array(alone.exactly(numbers(stopped), numbers(MASS)))
        assert np.dot(direction, exactly) == 0


@pytest.mark.parametrize("seed", range(200))
def test_contacts_at_rest_do_what_gauss_s_principle_says(seed):
    random = np.random.default_rng(seed)
    limit, load = random.uniform(0, 1, 3), 2 * random.normal(size=2)
    along = random.normal()
    # At rest, on each of the lines, and in motion.
    velocity = [(0, 0), (along, -along), (along, along), (0, along), random.normal(size=2)]
    robot = numbers_of(consistent())
    rubbing = dataclasses.replace(robot, drive_frictions=(1.0, 1.0))
    system = types.SimpleNamespace(
        numbers=rubbing,
        balance=lambda state, held: (
            np.array([0.0, 0.0, load[0], 0.0, load[1]]),
            np.array([limit[2], 1.0, limit[0], limit[1]]),
        ),
    )
    mass = tuple(rubbing.masses[[2, 4]])
    for lower, height in velocity:
        state = np.array([0.0] * 7 + [lower, 0.0, height])
        modes = np.sign(rubbing.contacts @ state[5:])
        true = _set_going(system, state, modes, Held(0.0, np.zeros(2), 0.0))
        found = started(
            (jnp.asarray(float(lower)), jnp.asarray(float(height))),
            tuple(map(jnp.asarray, load)),
            contacts(tuple(limit), mass),
        )
        assert [*map(float, found.side)] == [true[2], true[3], true[0]]
        held = np.array([*map(float, found.line)]) + float(found.origin)
        assert np.array_equal(held == 1, np.array(found.side) == 0)
