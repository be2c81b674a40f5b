"""A state's coordinates and their names."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import (
    HEIGHT,
    LOWER,
    TILT,
    UPPER,
    State,
    X,
    carriages,
    driven,
    pose,
    rest,
)

NAMES = ["x_e", "delta_e", "q_3", "q_4", "y_e"]
VIEWS = {pose: ["x_e", "y_e"], carriages: ["q_3", "q_4"], driven: ["q_3", "y_e"]}


def test_places_are_those_of_the_coordinates():
    assert [NAMES[i] for i in (X, TILT, LOWER, UPPER, HEIGHT)] == NAMES


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: view.__name__)
@pytest.mark.parametrize("module", [np, jnp], ids=lambda module: module.__name__)
@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
def test_a_view_has_its_coordinates_along_the_last_axis(view, module, shape):
    coordinates = module.asarray(np.random.default_rng(0).normal(size=(*shape, 5)))
    found = view(coordinates)
    expected = np.stack([coordinates[..., NAMES.index(name)] for name in VIEWS[view]], axis=-1)
    assert isinstance(found, type(coordinates))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("to", [np.asarray, jnp.asarray], ids=["numpy", "jax"])
def test_a_state_s_views_are_of_its_position(to):
    state = State(jnp.arange(10.0).reshape(2, 5), jnp.zeros((2, 5)))
    state = jax.tree.map(to, state)
    for view in VIEWS:
        np.testing.assert_array_equal(getattr(state, view.__name__), view(state.position))
    np.testing.assert_array_equal(state.tilt, [1, 6])


def test_a_resting_end_effector_lies_between_the_carriages():
    robot = consistent()
    lower, upper, height = jnp.asarray(0.5), jnp.asarray(0.6), jnp.asarray(0.3)
    state = rest(robot, lower, upper, height)
    share = height / robot.frame.height
    assert float(state.pose[0]) == pytest.approx(0.5 + 0.1 * float(share), rel=1e-15)
    assert jnp.all(state.carriages == jnp.stack([lower, upper]))
    assert jnp.all(state.velocity == 0)
