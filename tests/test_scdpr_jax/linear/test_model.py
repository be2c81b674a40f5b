import control
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.engines import stepping
from scdpr_jax.linear.model import (
    external_forces,
    linearise,
    mass_matrix,
    stiffness_matrix,
    without_drives,
)
from scdpr_jax.robot.cable import potential
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import accelerations, masses
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent, published
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State

EPS = float(np.finfo(float).eps)
FRICTIONLESS = replace(consistent(), {"friction_coefficient": 0.0})
ALIGNED = jnp.array([1.0, 0.0, 1.0, 1.0, 0.4])
height = st.floats(0.25, 0.85)
offset = st.floats(0.05, 0.2)

printed_stiffness = jax.jit(stiffness_matrix)
hessian = jax.jit(jax.hessian(potential, argnums=1))
state_space = jax.jit(linearise)


@jax.jit
def state_derivative(robot, state, inputs):
    position, velocity = state[:5], state[5:]
    torque = motor_torque(robot.drive, inputs[:2])
    acceleration = accelerations(
        robot, State(position, velocity), torque=torque, knock=inputs[2]
    )
    return jnp.concatenate([velocity, acceleration])


jacobians = jax.jit(jax.jacfwd(state_derivative, argnums=(1, 2)))


@jax.jit
def unexplained(robot, velocity, torque):
    """What the aligned robot's inertia takes beyond Eq. (21)."""
    found = accelerations(
        robot, State(ALIGNED, velocity), torque=torque, knock=jnp.asarray(0.0)
    )
    forces = external_forces(robot, velocity[:4], torque=torque)
    return masses(robot)[:4] * found[:4] - forces


@st.composite
def poses(draw):
    x = draw(st.floats(0.3, 1.9))
    lower, upper = (x + draw(st.floats(-0.1, 0.1)) for _ in range(2))
    return jnp.array([x, draw(st.floats(-0.2, 0.2)), lower, upper, draw(height)])


@hypothesis.given(height, offset, offset, st.floats(10, 500))
def test_equation_20_is_the_hessian_of_the_potential(height, lower, upper, tension):
    numbers = {"lower_offset": lower, "upper_offset": upper, "effective_pretension": tension}
    robot = replace(consistent(), numbers)
    aligned = ALIGNED.at[4].set(height)
    derived = hessian(robot, aligned)[:4, :4]
    error = printed_stiffness(robot, jnp.asarray(height)) - derived
    # Entries are 2T over paths of 0.05 m at least, which roundings of 2 m enter.
    assert jnp.max(jnp.abs(error)) <= 2 * tension / 0.05 * 8 * EPS * 2 / 0.05


@pytest.mark.parametrize("y", [0.3, 0.7])
def test_printed_k21_contradicts_the_potential(y):
    robot = consistent()
    tension, z_1, z_2 = 85.0, 1.112 - y - 0.1405, y - 0.1405
    printed = 2 * tension * (1 / z_2 - 1 / z_1)
    derived = hessian(robot, ALIGNED.at[4].set(y))[1, 0]
    assert abs(printed - derived) > 5 * abs(derived)


def test_printed_k21_would_leave_the_matrix_asymmetric():
    used = printed_stiffness(consistent(), jnp.asarray(0.3))
    printed = used.at[1, 0].set(2 * 85.0 * (1 / (0.3 - 0.1405) - 1 / (1.112 - 0.3 - 0.1405)))
    assert jnp.array_equal(used, used.T)
    assert jnp.abs(printed - printed.T).max() > 100


def test_mass_matrix_is_equation_19():
    assert jnp.array_equal(
        mass_matrix(published()), jnp.diag(jnp.array([2.1, 2.5198e-2, 1.2, 1.2]))
    )


def test_without_drives_neither_drive_rubs_however_unequal_they_are():
    numbers = {"drive_friction": 0.3, "drive_friction_difference": 0.2}
    bare = without_drives(replace(consistent(), numbers)).drive
    np.testing.assert_array_equal(bare.frictions, 0.0)


def test_masses_without_drives_are_equation_19():
    used = masses(without_drives(consistent()))[:4]
    assert jnp.array_equal(used, jnp.diagonal(mass_matrix(consistent())))


@hypothesis.given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-5, 5), st.floats(-5, 5))
def test_equation_21_is_what_an_aligned_robot_feels(lower, upper, first, second):
    velocity = jnp.array([0.3, 0.1, lower, upper, 0.0])
    error = unexplained(without_drives(consistent()), velocity, jnp.array([first, second]))
    # Sums of forces of up to 2 * 5 / 0.073 N and the loop's 2T.
    assert jnp.max(jnp.abs(error)) <= 16 * EPS * (2 * 5 / 0.073 + 2 * 85)


@hypothesis.given(poses())
def test_state_space_is_the_jacobian_of_the_equations_of_motion(position):
    found = state_space(FRICTIONLESS, position)
    rest = jnp.concatenate([position, jnp.zeros(5)])
    in_state, in_inputs = jacobians(FRICTIONLESS, rest, jnp.zeros(3))
    # Stiffnesses of up to 2T / 0.05 over the smallest inertia, roundings of 2 m in 0.05 m.
    tolerance = 2 * 85 / 0.05 / 0.025 * 8 * EPS * 2 / 0.05
    assert jnp.max(jnp.abs(found.state_matrix - in_state)) <= tolerance
    assert jnp.max(jnp.abs(found.input_matrix - in_inputs)) <= 16 * EPS * 10


@hypothesis.given(poses())
def test_drift_is_what_the_robot_does_at_the_pose(position):
    found = state_space(FRICTIONLESS, position).drift
    rest = jnp.concatenate([position, jnp.zeros(5)])
    expected = state_derivative(FRICTIONLESS, rest, jnp.zeros(3))
    # Forces of up to 4T over the smallest inertia, roundings of 2 m in 0.05 m.
    tolerance = 4 * 85 / 0.025 * 8 * EPS * 2 / 0.05
    assert jnp.max(jnp.abs(found - expected)) <= tolerance


@hypothesis.given(height)
def test_aligned_pose_is_in_balance(height):
    drift = state_space(FRICTIONLESS, ALIGNED.at[4].set(height)).drift
    assert jnp.max(jnp.abs(drift)) <= 4 * 85 / 0.025 * 8 * EPS


@hypothesis.given(height)
def test_two_displacements_and_the_height_rate_have_known_eigenvalues(height):
    robot = consistent()
    matrix = np.asarray(state_space(robot, ALIGNED.at[4].set(height)).state_matrix)
    eigenvalues = np.linalg.eigvals(matrix)
    reflected = 2 / 0.073**2
    decay = -0.2124 * reflected / (2.1 + 1.2734e-2 * reflected)
    # A double zero may split by the square root of a rounding of the largest entry.
    tolerance = np.sqrt(8 * EPS * np.abs(matrix).max())
    assert np.sum(np.abs(eigenvalues) <= tolerance) == 2
    assert np.min(np.abs(eigenvalues - decay)) <= tolerance


@hypothesis.given(height)
def test_every_other_eigenvalue_decays(height):
    matrix = np.asarray(state_space(consistent(), ALIGNED.at[4].set(height)).state_matrix)
    real_parts = np.sort(np.linalg.eigvals(matrix).real)
    assert np.all(real_parts[:-2] < -1e-3)


@hypothesis.given(height)
def test_without_drives_nothing_decays(height):
    robot = without_drives(consistent())
    matrix = np.asarray(state_space(robot, ALIGNED.at[4].set(height)).state_matrix)
    eigenvalues = np.linalg.eigvals(matrix)
    # Double zeros split by the square root of a rounding.
    assert np.max(np.abs(eigenvalues.real)) <= np.sqrt(8 * EPS * np.abs(matrix).max())


PERIOD, COUNT = 1e-3, 500


@jax.jit
def nonlinear(start, voltage, knock):
    inputs = stepping.Inputs(
        PERIOD * jnp.ones(COUNT),
        jnp.broadcast_to(voltage, (COUNT, 2)),
        jnp.broadcast_to(knock, COUNT),
    )
    states = stepping.simulate(FRICTIONLESS, start, inputs)
    return jnp.concatenate([states.position, states.velocity], axis=1)


def linear(start, inputs):
    """The state space's response to held inputs, by python-control."""
    model = state_space(FRICTIONLESS, ALIGNED)
    system = control.ss(
        np.asarray(model.state_matrix), np.asarray(model.input_matrix), np.eye(10), 0
    )
    times = PERIOD * np.arange(COUNT + 1)
    held = np.outer(inputs, np.ones(COUNT + 1))
    return control.forced_response(system, times, held, np.asarray(start)).outputs.T


def response_error(amplitude, vertical):
    start = amplitude * np.array([1e-2, 1e-2, -1e-2, 5e-3, 0, 0, 0, 0.1, 0, 0])
    inputs = amplitude * np.array([0.5, 0.5 - vertical, 2.0])
    begin = State(ALIGNED + jnp.asarray(start[:5]), jnp.asarray(start[5:]))
    found = nonlinear(begin, jnp.asarray(inputs[:2]), jnp.asarray(inputs[2]))
    origin = np.concatenate([ALIGNED, np.zeros(5)])
    return np.abs(np.asarray(found) - origin - linear(start, inputs)).max(axis=0)[:5]


@pytest.fixture(scope="module")
def response_errors():
    return [response_error(amplitude, vertical=0.5) for amplitude in (1.0, 0.5, 0.25)]


def test_linear_response_errs_by_the_amplitude_squared(response_errors):
    ratios = np.array(response_errors[:-1]) / np.array(response_errors[1:])
    # 4 in the limit; the next order adds as many percent as the amplitude is of the paths.
    assert np.all((ratios > 3.5) & (ratios < 4.6))


def test_linear_response_is_close_at_small_angles(response_errors):
    # Angles of 0.25 * 2 cm / 0.26 m: an error of some of their square of the displacement.
    assert np.all(response_errors[-1] <= 0.02**2)


def test_without_vertical_motion_the_horizontal_error_is_the_amplitude_cubed():
    errors = [response_error(amplitude, vertical=0.0)[:4] for amplitude in (1.0, 0.5)]
    # 8 in the limit: the aligned robot is its own mirror image.
    assert np.all((errors[0] / errors[1] > 7) & (errors[0] / errors[1] < 9))


@pytest.mark.slow
def test_linear_models_are_differentiable_in_parameters_and_height():
    def matrices(radius, tension, y):
        numbers = {"effective_radius": 0.073 * radius, "effective_pretension": 85 * tension}
        robot = replace(smoothed(consistent()), numbers)
        model = linearise(robot, ALIGNED.at[4].set(y))
        return model.state_matrix / 1e3, model.input_matrix, stiffness_matrix(robot, y) / 1e3

    arguments = (jnp.asarray(1.0), jnp.asarray(1.0), jnp.asarray(0.5))
    check_grads(jax.jit(matrices), arguments, order=1, modes=("fwd", "rev"))
