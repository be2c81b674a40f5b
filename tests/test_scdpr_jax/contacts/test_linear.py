"""Contacts of the linear robot: their assumed friction, and what their branch holds."""

import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.branches import DIRECTIONS
from scdpr_jax.contacts.linear import Start, carriage, pulleys
from scdpr_jax.engines.propagator import propagator
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State

ROBOT = replace(consistent(), {"drive_friction": 3.0})
TABLES = propagator(ROBOT, height=jnp.asarray(0.45), duration=jnp.asarray(5e-3))


def start(velocity, pushes=(0.0, 0.0, 0.0)):
    numbers = [jnp.asarray(float(push)) for push in pushes]
    return Start(
        TABLES,
        State(jnp.zeros(5), jnp.asarray(velocity, float)),
        dict(zip((LOWER, UPPER, HEIGHT), numbers, strict=True)),
    )


END = State(*(scale * jnp.array([1.0, 0.0, 1.2, 1.3, 1.7]) for scale in (0.01, 0.3)))


@pytest.mark.parametrize("way", [1, -1])
def test_a_carriage_that_slides_has_all_its_friction_against_it(way):
    sliding = carriage(start([0, 0, 0, way * 0.2, 0]), UPPER)
    friction = sliding.friction()[UPPER]
    assert float(friction.constant) == pytest.approx(way * float(TABLES.limit[1]))
    assert float(friction.rising) == 0
    end = sliding.held(END)
    np.testing.assert_array_equal(end.position, END.position)
    np.testing.assert_array_equal(end.velocity, END.velocity)


def test_a_carriage_that_is_held_has_the_friction_of_its_load_and_stays():
    push = float(TABLES.limit[1]) / 2
    held = carriage(start([0, 0, 0, 0, 0], (0, push, 0)), UPPER)
    assert float(held.friction()[UPPER].constant) == push
    end = held.held(END)
    assert (float(end.position[UPPER]), float(end.velocity[UPPER])) == (0, 0)
    assert end.position[LOWER] == END.position[LOWER]


@pytest.mark.parametrize(
    ("velocity", "stuck"),
    [((0.1, -0.1), [0]), ((0.1, 0.1), [1]), ((0.0, 0.1), [2]), ((0.0, 0.0), [0, 1, 2])],
)
def test_contacts_that_hold_keep_their_place_to_the_bit(velocity, stuck):
    pair = pulleys(start([0, 0, velocity[0], 0, velocity[1]]))
    end = pair.held(END)
    for part in (end.position, end.velocity):
        speeds = np.array(DIRECTIONS) @ [float(part[LOWER]), float(part[HEIGHT])]
        assert [i for i in range(3) if speeds[i] == 0] == stuck


def test_a_pair_that_slides_on_has_no_departure():
    pair = pulleys(start([0, 0, 0.3, 0, 0.1]))
    end = State(jnp.full(5, 0.0015), jnp.asarray([0.3, 0, 0.3, 0.3, 0.1]))
    deviations = pair.departure(end).deviations
    assert set(deviations) == {LOWER, HEIGHT}
    assert all(float(m) == 0 for each in deviations.values() for m in each.moments)
