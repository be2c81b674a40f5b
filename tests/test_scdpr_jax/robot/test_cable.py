import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.cable import (
    cable_angles,
    carriage_stiffness,
    loop_forces,
    paths,
    potential,
    small_cable_angles,
    tension_increase,
)
from scdpr_jax.robot.dynamics import drive_forces, gravity_force, knock_forces
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import rest

EPS = float(np.finfo(float).eps)
TENSION = 85.0
ROBOT = replace(
    consistent(), {"effective_pretension": TENSION, "lower_offset": 0.12, "upper_offset": 0.16}
)
# Each force is a handful of products of sines and lengths below 2 m, times 2T; a path is at
# least 0.09 m long, which divides roundings of coordinates of some 2 m.
FORCE_TOLERANCE = 2 * TENSION * 8 * EPS * 2 / 0.09


@st.composite
def poses(draw):
    x = draw(st.floats(0.3, 1.9))
    lower, upper = (x + draw(st.floats(-0.1, 0.1)) for _ in range(2))
    return jnp.array([x, draw(st.floats(-0.2, 0.2)), lower, upper, draw(st.floats(0.22, 0.85))])


forces_of = jax.jit(loop_forces)
angles_of = jax.jit(cable_angles)
small_angles_of = jax.jit(small_cable_angles)
gradient = jax.jit(jax.grad(potential, argnums=1))
hessian = jax.jit(jax.hessian(potential, argnums=1))
stiffness_of = jax.jit(carriage_stiffness)
rest_of = jax.jit(rest)
weight_of = jax.jit(gravity_force)


@hypothesis.given(poses())
def test_pull_is_minus_the_gradient_of_the_potential(position):
    error = forces_of(ROBOT, position).pull + gradient(ROBOT, position)
    assert jnp.max(jnp.abs(error)) <= FORCE_TOLERANCE


@hypothesis.given(poses(), st.floats(0, 10))
def test_weight_is_in_the_potential(position, gravity):
    heavy = eqx.tree_at(lambda r: r.gravity, ROBOT, jnp.asarray(gravity))
    expected = forces_of(heavy, position).pull + weight_of(heavy)
    assert jnp.max(jnp.abs(expected + gradient(heavy, position))) <= FORCE_TOLERANCE


@hypothesis.given(st.floats(-0.2, 0.2))
def test_a_knock_does_the_work_of_its_force_where_it_acts(arm):
    """Its moment is that of a horizontal force at a height above the centre, near upright."""
    robot = eqx.tree_at(lambda r: r.end_effector.knock_arm, consistent(), jnp.asarray(arm))
    found = np.asarray(knock_forces(robot, jnp.asarray(7.0)))
    step = 1e-5

    def hit(x, angle):
        return x - arm * np.sin(angle)

    slopes = [hit(step, 0.0) - hit(-step, 0.0), hit(0.0, step) - hit(0.0, -step)]
    np.testing.assert_allclose(found[:2], 7.0 * np.array(slopes) / (2 * step), atol=1e-9)
    assert not found[2:].any()


@hypothesis.given(poses())
def test_pull_is_the_printed_equations_7_8_and_16(position):
    alpha, beta, gamma = np.asarray(angles_of(ROBOT, position))
    tilt = float(position[1])
    a, b = 0.12, 0.16
    printed = [
        2 * TENSION * (np.sin(alpha) - np.sin(beta)),
        2 * TENSION * (a * np.sin(alpha - tilt) + b * np.sin(beta - tilt)),
        -2 * TENSION * (np.sin(gamma) + np.sin(alpha)),
        2 * TENSION * (np.sin(gamma) + np.sin(beta)),
    ]
    pull = np.asarray(forces_of(ROBOT, position).pull)
    assert np.max(np.abs(pull[:4] - printed)) <= FORCE_TOLERANCE


@hypothesis.given(poses())
def test_vertical_pull_that_is_not_printed_is_the_cables_cosines(position):
    alpha, beta, _ = np.asarray(angles_of(ROBOT, position))
    expected = -2 * TENSION * (np.cos(alpha) - np.cos(beta))
    assert abs(float(forces_of(ROBOT, position).pull[4]) - expected) <= FORCE_TOLERANCE


@hypothesis.given(poses())
def test_guides_carry_the_printed_normal_forces(position):
    alpha, beta, gamma = np.asarray(angles_of(ROBOT, position))
    expected = 2 * TENSION * (np.cos(gamma) + np.cos([alpha, beta]))
    normal = np.asarray(forces_of(ROBOT, position).normal)
    assert np.max(np.abs(normal - expected)) <= FORCE_TOLERANCE


@hypothesis.given(poses())
def test_loop_pushes_the_whole_robot_nowhere(position):
    pull = forces_of(ROBOT, position).pull
    assert abs(float(pull[0] + pull[2] + pull[3])) <= FORCE_TOLERANCE


@hypothesis.given(poses())
def test_carriage_stiffness_is_the_carriages_rows_of_the_hessian(position):
    error = stiffness_of(ROBOT, position) - hessian(ROBOT, position)[2:4]
    # As the forces, over one more length.
    assert jnp.max(jnp.abs(error)) <= FORCE_TOLERANCE / 0.09


@hypothesis.given(poses())
def test_angles_of_equation_4_have_the_tangents_of_equation_17(position):
    error = jnp.tan(angles_of(ROBOT, position)) - small_angles_of(ROBOT, position)
    # Tangents below 2; roundings of the coordinates over the shortest path.
    assert jnp.max(jnp.abs(error)) <= 8 * EPS * 2 / 0.09


@hypothesis.given(poses())
def test_small_angles_are_right_to_third_order(position):
    small = small_angles_of(ROBOT, position)
    error = jnp.abs(angles_of(ROBOT, position) - small)
    # |arctan t - t| <= |t|^3 / 3, beside roundings.
    assert jnp.all(error <= jnp.abs(small) ** 3 / 3 + 8 * EPS * 2 / 0.09)


@hypothesis.given(st.floats(0.3, 1.9), st.floats(-0.2, 0.2), st.floats(0.22, 0.85))
def test_at_rest_the_loop_holds_the_end_effector(lower, lean, height):
    start = rest_of(ROBOT, *(jnp.asarray(number) for number in (lower, lower - lean, height)))
    pull = forces_of(ROBOT, start.position).pull
    assert jnp.max(jnp.abs(pull[jnp.array([0, 1, 4])])) <= FORCE_TOLERANCE


@hypothesis.given(st.floats(-0.2, 0.2), st.floats(0.22, 0.85))
def test_at_rest_the_carriages_need_the_friction_of_their_slope(lean, height):
    start = rest_of(ROBOT, *(jnp.asarray(number) for number in (1.0, 1.0 - lean, height)))
    loop = forces_of(ROBOT, start.position)
    needed = jnp.abs(loop.pull[2:4]) / loop.normal
    # Force over normal force, each within the tolerance of 4T and more.
    tolerance = 2 * FORCE_TOLERANCE / TENSION
    assert jnp.max(jnp.abs(needed - abs(lean) / 1.112)) <= tolerance


def test_rest_lies_on_the_line_between_the_carriages():
    start = rest_of(ROBOT, jnp.asarray(1.0), jnp.asarray(0.9), jnp.asarray(0.4))
    angles = angles_of(ROBOT, start.position)
    assert jnp.max(jnp.abs(angles - start.position[1])) <= 16 * EPS


@hypothesis.given(st.floats(-5, 5), st.floats(-5, 5))
def test_lower_carriage_feels_the_tension_increase_of_equation_6_twice(first, second):
    torque = jnp.array([first, second])
    pushed = drive_forces(ROBOT, torque)[2]
    expected = 2 * tension_increase(ROBOT, torque)
    assert abs(float(pushed - expected)) <= 8 * EPS * 5 / 0.073


@hypothesis.given(poses())
def test_lengths_and_angles_make_the_paths(position):
    for path in paths(ROBOT, position):
        sine, cosine = path.direction
        assert abs(float(path.length * sine - path.horizontal)) <= 4 * EPS
        assert abs(float(path.length * cosine - path.vertical)) <= 4 * EPS


def test_loop_forces_are_differentiable_in_pose_and_pretension():
    def pull(position, pretension):
        return loop_forces(replace(ROBOT, {"effective_pretension": pretension}), position).pull

    position = jnp.array([1.0, 0.05, 1.03, 0.96, 0.4])
    arguments = (position, jnp.asarray(TENSION))
    check_grads(jax.jit(pull), arguments, order=1, modes=("fwd", "rev"))
