"""The pair's motion between two events of a step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.branches import Contacts, branch_at_start
from scdpr_jax.contacts.motion import Assumed, beginning, onwards
from scdpr_jax.contacts.polynomial import Cubic, Quadratic

MASS, LIMIT = (6.0, 7.0), (0.3, 0.5, 0.4)
VELOCITIES = [(1.0, 0.2), (0.3, 0.3), (0.2, -0.2), (0.0, 0.4), (-0.1, 0.3), (0.0, 0.0)]


def numbers(values):
    return tuple(jnp.asarray(float(value)) for value in values)


def assumed(velocity, load, *, damping=(0.2, 0.1), stiffness=0.3):
    contacts = Contacts(numbers(MASS), numbers(LIMIT))
    branch = branch_at_start(numbers(velocity), numbers(load), contacts)
    zero = jnp.asarray(0.0)
    return Assumed(
        branch=branch,
        mobility=branch.mobility(contacts.mass),
        velocity=tuple(
            Cubic(Quadratic(*numbers((v, 0.1 * v, -0.05 * v))), zero) for v in velocity
        ),
        load=tuple(Quadratic(*numbers((p, 0.1, 0.02))) for p in load),
        damping=numbers(damping),
        stiffness=jnp.asarray(stiffness),
    ), contacts


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_what_friction_leaves_of_the_load_moves_the_pair(velocity):
    motion, contacts = assumed(velocity, (0.2, 0.1))
    fresh = numbers((0, 0, 0))
    start = beginning(motion, fresh, contacts)
    time = jnp.asarray(0.4)
    load, friction = (
        np.array([part(time) for part in parts]) for parts in (start.load, start.friction)
    )
    pull = np.array([part(time) for part in start.pull])
    a, b, c = motion.mobility
    moved = np.array([[a, b], [b, c]]) @ pull
    np.testing.assert_allclose(load / MASS - friction, moved, rtol=0, atol=1e-15)


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_a_motion_goes_on_as_its_loads_accelerate_it(velocity):
    motion, contacts = assumed(velocity, (0.2, 0.1))
    later = onwards(
        motion,
        motion.branch,
        begin=jnp.asarray(0.25),
        fresh=numbers((0, 0, 0)),
        velocity=numbers(velocity),
        load=numbers((0.2, 0.1)),
        contacts=contacts,
    )
    mobility = np.array(motion.mobility)
    matrix = mobility[[[0, 1], [1, 2]]]
    speed, slope = (
        np.array([v.quadratic.later(jnp.asarray(t)).linear for v in later.velocity])
        for t in (0.0, 1.0)
    )
    pulls = [np.array([p(t) for p in later.pull]) for t in (0.0, 1.0)]
    np.testing.assert_allclose(speed, matrix @ pulls[0], rtol=0, atol=1e-15)
    # A quadratic velocity has no more than the pull's straight part.
    straight = np.array([p.linear for p in later.pull])
    np.testing.assert_allclose(slope - speed, matrix @ straight, rtol=0, atol=1e-15)


def test_cables_pull_back_what_strays_from_the_assumed_motion():
    motion, contacts = assumed((1.0, 0.2), (0.2, 0.1), damping=(0.0, 0.0))
    begin = jnp.asarray(0.25)
    led = motion.velocity[0].quadratic(begin)

    def slope(lower):
        return (
            onwards(
                motion,
                motion.branch,
                begin=begin,
                fresh=numbers((0, 0, 0)),
                velocity=(lower, jnp.asarray(0.2)),
                load=numbers((0.2, 0.1)),
                contacts=contacts,
            )
            .load[0]
            .linear
        )

    # By the assumed motion the load is the step's own; a faster carriage is held back.
    assert float(slope(led)) == pytest.approx(0.1 + 2 * 0.25 * 0.02, rel=1e-14)
    assert float(jax.grad(slope)(led)) == pytest.approx(-0.3, rel=1e-14)
