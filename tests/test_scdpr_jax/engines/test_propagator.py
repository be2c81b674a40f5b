"""The tables of a linear step against matrix exponentials."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from scdpr_jax.engines.propagator import propagator
from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

HEIGHT, EPS = 0.45, np.finfo(float).eps
PLANE = [0, 1, 2, 3, 5, 6, 7, 8]
ROBOT = replace(consistent(), {"drive_friction": 0.1, "drive_friction_difference": 0.04})
space = linearise(ROBOT, jnp.array([0.0, 0.0, 0.0, 0.0, HEIGHT]))
MATRIX = np.asarray(space.state_matrix)[np.ix_(PLANE, PLANE)]
tabulated = jax.jit(lambda h: propagator(ROBOT, height=jnp.asarray(HEIGHT), duration=h))


@pytest.fixture(scope="module", params=[1e-4, 5e-3, 1.25e-2])
def step(request):
    return request.param, tabulated(jnp.asarray(request.param))


def test_the_transition_is_the_matrix_exponential(step):
    duration, tables = step
    expected = expm(duration * MATRIX)
    scale = np.abs(expected).max()
    assert np.abs(tables.transition - expected).max() <= 64 * EPS * scale


@pytest.mark.parametrize("rising", [0, 1])
def test_responses_are_those_to_accelerations_constant_and_growing(step, rising):
    duration, tables = step
    # An acceleration of 1 m/s a step on a carriage, as states of their own.
    for column, row in ((0, 6), (1, 7)):
        larger = np.zeros((10, 10))
        larger[:8, :8] = duration * MATRIX
        larger[row, 8] = 1.0
        larger[8, 9] = 1.0
        expected = expm(larger)[:8, 8 + rising]
        scale = np.abs(expected).max()
        found = np.asarray(tables.responses[rising])[:, column]
        assert np.abs(found - expected).max() <= 64 * EPS * scale


def test_the_height_falls_into_the_step_of_a_damped_mass(step):
    duration, tables = step
    full = np.asarray(space.state_matrix)
    damping = -full[9, 9]
    expected = (1 - np.exp(-damping * duration)) / damping
    assert float(tables.height[0, 0]) == pytest.approx(expected, rel=1e-11)
    assert float(tables.height[1, 0]) == pytest.approx(np.exp(-damping * duration), rel=1e-13)


def test_the_loop_ties_a_carriage_as_the_state_space_says(step):
    duration, tables = step
    np.testing.assert_allclose(tables.pull, duration * MATRIX[6:, :4], rtol=1e-14)
    np.testing.assert_allclose(tables.coupling, duration**2 * MATRIX[4:, 2:4].T, rtol=1e-14)


def test_friction_that_is_not_followed_has_no_table():
    tables = propagator(
        ROBOT,
        height=jnp.asarray(HEIGHT),
        duration=jnp.asarray(1e-3),
        rubbing_drives=False,
    )
    assert tables.drives is None


def test_a_smooth_law_is_refused():
    with pytest.raises(TypeError, match="must be `Coulomb`"):
        propagator(smoothed(ROBOT), height=jnp.asarray(HEIGHT), duration=jnp.asarray(1e-3))
