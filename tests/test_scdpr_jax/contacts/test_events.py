"""Events of the lower carriage and the drives in a step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.branches import Contacts, branch_at_start
from scdpr_jax.contacts.events import deviation
from scdpr_jax.contacts.motion import Assumed
from scdpr_jax.contacts.polynomial import Cubic, Quadratic

MASS = (6.0, 7.0)
LIMIT = (0.3, 0.5, 0.4)


def contacts(limit=LIMIT, mass=MASS):
    return Contacts(*(tuple(map(jnp.asarray, part)) for part in (mass, limit)))


deviated = jax.jit(deviation)


def assumed(velocity, load):
    """A motion without damping and cables, under even forces, and its contacts."""
    own = contacts()
    velocity, load = (tuple(map(jnp.asarray, map(float, part))) for part in (velocity, load))
    branch = branch_at_start(velocity, load, own)
    mobility = branch.mobility(own.mass)
    pull = [p - f for p, f in zip(load, branch.friction(own.limit), strict=True)]
    none = jnp.zeros(())
    slopes = (
        mobility[0] * pull[0] + mobility[1] * pull[1],
        mobility[1] * pull[0] + mobility[2] * pull[1],
    )
    return Assumed(
        branch=branch,
        mobility=mobility,
        velocity=tuple(
            Cubic(Quadratic(v, a, none), none) for v, a in zip(velocity, slopes, strict=True)
        ),
        load=tuple(Quadratic(p, none, none) for p in load),
        damping=(none, none),
        stiffness=none,
    ), own


def end(motion, found):
    """Displacement and velocity at the step's end."""
    return np.array(
        [
            [v.constant + v.linear / 2 + own[1], v.constant + v.linear + own[0]]
            for (v, _), own in zip(
                motion.velocity, zip(*found.moments, strict=True), strict=True
            )
        ]
    )


def stepped(velocity, load):
    """The same by many small steps, in each of which the contacts agree by turns."""
    steps = 20_000
    velocity, moved = np.array(velocity, float), np.zeros(2)
    lines = np.array([[1, 1], [1, -1], [1, 0]], float)
    mass = np.array(MASS)
    friction = np.zeros(3)
    for _ in range(steps):
        free = velocity + np.array(load) / mass / steps
        for _ in range(8):
            for i, line in enumerate(lines):
                others = free - (lines.T @ friction - line * friction[i]) / mass
                answer = line @ (line / mass)
                most = LIMIT[i] / steps
                friction[i] = np.clip(line @ others / answer, -most, most)
        before, velocity = velocity, free - lines.T @ friction / mass
        moved += (before + velocity) / 2 / steps
    return np.stack([moved, velocity], axis=1)


@pytest.mark.parametrize(
    ("velocity", "load"),
    [
        ((1.0, 0.2), (0.1, -0.1)),
        pytest.param((0.06, 0.02), (0.1, 0.2), marks=pytest.mark.slow),
        pytest.param((0.06, -0.02), (-0.3, 0.4), marks=pytest.mark.slow),
        pytest.param((0.02, 0.05), (0.0, -0.9), marks=pytest.mark.slow),
        pytest.param((0.0, -0.05), (0.3, 1.4), marks=pytest.mark.slow),
    ],
)
def test_end_of_a_step_is_that_of_many_small_ones(velocity, load):
    motion, own = assumed(velocity, load)
    found = deviated(motion, own)
    # The small steps err by their length times a change of the acceleration.
    assert np.abs(end(motion, found) - stepped(velocity, load)).max() <= 5e-5


def test_a_pair_that_slides_on_deviates_by_nothing():
    found = deviated(*assumed((1.0, 0.2), (0.1, -0.1)))
    assert np.all(np.asarray(found.moments) == 0)
    assert float(found.branch.origin) == 0


def test_a_pair_that_stops_rests_exactly():
    motion, own = assumed((0.06, 0.02), (0.1, 0.2))
    found = deviated(motion, own)
    assert float(found.branch.origin) == 1
    # Its momentum is gone, up to a few roundings.
    assert np.abs(end(motion, found)[:, 1]).max() <= 16 * np.finfo(float).eps
