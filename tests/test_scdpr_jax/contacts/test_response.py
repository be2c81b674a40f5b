"""How a robot answers friction that deviates within a step."""

import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.response import Departure, Response, departed, deviating
from scdpr_jax.robot.state import State

STEP, DAMPING, STIFFNESS, TIE = 1e-3, 40.0, 300.0, 200.0


def numbers(*values):
    return tuple(jnp.asarray(float(value)) for value in values)


def coordinates(*values):
    """The first coordinates of a robot, at rest in all others."""
    return jnp.zeros(5).at[: len(values)].set(jnp.array(values))


def end_of(moments, departures=1):
    """The end of a step in which the first coordinate feels a deviation, tied to the second."""
    damped = jnp.asarray(STEP * DAMPING)
    coupling = coordinates(-(STEP**2) * STIFFNESS, STEP**2 * TIE)
    departure = Departure({0: deviating(moments)}, lambda velocity: {})
    return departed(
        State(coordinates(0.0), coordinates(0.0)),
        [departure] * departures,
        duration=jnp.asarray(STEP),
        responses={0: Response(damped, coupling)},
    )


def test_the_end_is_that_of_the_robot_under_the_deviation():
    # An even deviation of 1 m/s a step: E_k = 1 / (k + 1).
    found = end_of(numbers(1, 1 / 2, 1 / 3, 1 / 4))
    steps = 20_000
    part, q, v = STEP / steps, np.zeros(2), np.zeros(2)
    for _ in range(steps):
        force = np.array([1 / STEP - DAMPING * v[0] - STIFFNESS * q[0], TIE * q[0]])
        v = v + part * force
        q = q + part * v
    # What is left out is of the next order in the step: (ch)^3/24 of the velocity.
    assert np.abs(np.array(found.velocity)[:2] - v).max() <= (STEP * DAMPING) ** 3 / 6
    assert np.abs(np.array(found.position)[:2] - q).max() <= STEP * (STEP * DAMPING) ** 2 / 6
    assert float(found.velocity[1]) == pytest.approx(v[1], rel=0.02)


def test_deviations_of_two_contacts_add_up():
    moments = numbers(1, 1 / 2, 1 / 3, 1 / 4)
    once, twice = end_of(moments), end_of(moments, departures=2)
    np.testing.assert_allclose(twice.velocity, 2 * np.array(once.velocity), rtol=1e-15)
    np.testing.assert_allclose(twice.position, 2 * np.array(once.position), rtol=1e-15)


def test_what_is_put_to_rest_is_so_after_everything_has_moved_it():
    rest = Departure({1: deviating(numbers(1, 1, 1, 1))}, lambda v: {1: jnp.zeros_like(v[1])})
    none = jnp.asarray(0.0)
    found = departed(
        State(coordinates(0.0), coordinates(0.0, 1.0)),
        [rest],
        duration=jnp.asarray(STEP),
        responses={1: Response(none, coordinates(0.0))},
    )
    assert float(found.velocity[1]) == 0
    assert float(found.position[1]) == STEP
