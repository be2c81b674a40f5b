import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import strategies as st

from scdpr_jax.robot.cable import loop_forces
from scdpr_jax.robot.loop_elasticity import (
    consistent_section,
    lengthening,
    loop_length,
    loop_stiffness,
    moving_length,
    published_section,
)
from scdpr_jax.robot.prototype import consistent

EPS = float(np.finfo(float).eps)
ROBOT = consistent()
place = st.floats(0.3, 1.9)
height = st.floats(0.2, 0.9)


def test_axial_stiffness_is_modulus_times_area():
    expected = 209.12e9 * np.pi * 1e-3**2
    assert abs(float(consistent_section().axial_stiffness) / expected - 1) <= 8 * EPS


def test_printed_modulus_is_a_hundredth():
    ratio = consistent_section().axial_stiffness / published_section().axial_stiffness
    assert abs(float(ratio) - 100) <= 1000 * EPS


def test_loop_of_table_1_has_eight_metres_and_a_third():
    assert abs(float(loop_length(ROBOT)) - (2 * (2 * 1.112 - 0.281) + 2 * 2.224)) <= 16 * EPS


def test_loop_stiffness_is_that_of_a_bar():
    expected = float(consistent_section().axial_stiffness) / 8.334
    found = float(loop_stiffness(ROBOT, consistent_section()))
    assert abs(found / expected - 1) <= 16 * EPS


@hypothesis.given(x=place, y=height)
def test_aligned_poses_have_one_length(x, y):
    position = jnp.asarray([x, 0.0, x, x, y])
    assert abs(float(lengthening(ROBOT, position))) <= 32 * EPS * 8.4


@hypothesis.given(x=place, lower=place, upper=place, y=height, tilt=st.floats(-0.2, 0.2))
def test_path_is_never_shorter_than_when_aligned(x, lower, upper, y, tilt):
    position = jnp.asarray([x, tilt, lower, upper, y])
    assert float(lengthening(ROBOT, position)) >= -32 * EPS * 8.4


def test_force_is_tension_times_the_gradient_of_the_length():
    position = jnp.asarray([1.0, 0.05, 1.05, 0.93, 0.4])
    gradient = jax.grad(moving_length, argnums=1)(ROBOT, position)
    pull = loop_forces(ROBOT, position).pull
    assert np.allclose(pull, -85.0 * gradient, atol=64 * EPS * 4 * 85)
