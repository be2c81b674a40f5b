import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.linear.model import linearise, mass_matrix, stiffness_matrix, without_drives
from scdpr_jax.linear.modes import (
    BOTH_HELD,
    CONDITIONS,
    DRIVEN,
    LOWER_HELD,
    PRINTED,
    Condition,
    Lower,
    Upper,
    modes,
    natural_frequencies,
)
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

EPS = float(np.finfo(float).eps)
ROBOT = consistent()
MIDDLE = 1.112 / 2
height = st.floats(0.25, 0.85)
tension = st.floats(20, 500)
every_condition = pytest.mark.parametrize(
    "condition", CONDITIONS, ids=lambda c: f"{c.lower.name}-{c.upper.name}"
)
# Eigenvalues within some roundings of the largest: at most 1/40 of it is the lowest here.
RELATIVE = 64 * 40 * EPS


@jax.jit
def frequencies(tension, height, condition):
    robot = replace(ROBOT, {"effective_pretension": tension})
    return natural_frequencies(robot, height, condition)


@jax.jit
def all_modes(robot, height, condition):
    return modes(robot, height, condition)


state_space = jax.jit(linearise)


def at(tension, height, condition):
    return np.asarray(frequencies(jnp.asarray(tension), jnp.asarray(height), condition))


def mass_of(condition):
    if condition.lower is Lower.DRIVEN:
        return masses(ROBOT)[:4]
    return jnp.diagonal(mass_matrix(ROBOT))


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        (PRINTED, (5.40, 7.14, 8.54)),
        (DRIVEN, (3.68, 4.86, 5.81)),
        (LOWER_HELD, (2.97, 3.93, 4.69)),
        (BOTH_HELD, (4.82, 6.38, 7.62)),
    ],
    ids=["free", "driven", "held", "both held"],
)
def test_first_modes_at_mid_height_are_those_the_paper_leads_to(condition, expected):
    found = [at(nominal, MIDDLE, condition)[0] for nominal in (200.0, 350.0, 500.0)]
    # Two decimals.
    assert np.max(np.abs(np.array(found) - expected)) <= 0.0051


def test_no_condition_gives_the_measured_frequencies_at_the_nominal_pretension():
    lowest = [at(200.0, MIDDLE, c)[0] for c in (PRINTED, DRIVEN, LOWER_HELD, BOTH_HELD)]
    assert min(lowest) > 1.2 * 2.4


@hypothesis.given(tension, height, st.floats(0.05, 0.2), st.floats(0.05, 0.2))
def test_both_held_is_the_closed_form_of_two_coordinates(tension, height, lower, upper):
    numbers = {"effective_pretension": tension, "lower_offset": lower, "upper_offset": upper}
    found = all_modes(replace(ROBOT, numbers), jnp.asarray(height), BOTH_HELD).frequency
    z_1, z_2 = 1.112 - height - upper, height - lower
    push = 2 * tension * (1 / z_1 + 1 / z_2) / 2.1
    turn = 2 * tension * (lower**2 / z_2 + lower + upper**2 / z_1 + upper) / 2.5198e-2
    cross = 2 * tension * (lower / z_2 - upper / z_1) / np.sqrt(2.1 * 2.5198e-2)
    mean, half = (push + turn) / 2, np.hypot((push - turn) / 2, cross)
    expected = np.sqrt([mean - half, mean + half]) / (2 * np.pi)
    assert np.allclose(found, expected, rtol=RELATIVE, atol=0)


@every_condition
@hypothesis.given(tension, height)
def test_frequencies_go_with_the_root_of_the_pretension(condition, tension, height):
    scaled = at(1.0, height, condition) * np.sqrt(tension)
    assert np.allclose(at(tension, height, condition), scaled, rtol=RELATIVE, atol=0)


@every_condition
def test_frequencies_are_positive_ascending_and_counted(condition):
    found = at(85.0, 0.4, condition)
    assert found.shape == (condition.modes,)
    assert np.all(np.diff(found) > 0)
    assert found[0] > 0


@pytest.mark.parametrize("condition", [PRINTED, DRIVEN], ids=["free", "driven"])
@hypothesis.given(height)
def test_frequencies_are_those_of_the_undamped_state_space(condition, height):
    undamped = replace(ROBOT, {"drive_damping": 0.0})
    robot = without_drives(ROBOT) if condition is PRINTED else undamped
    pose = jnp.array([1.0, 0.0, 1.0, 1.0, height])
    matrix = np.asarray(state_space(robot, pose).state_matrix)
    # Sliding as a whole and the height: four zeros; then each frequency twice.
    squares = np.sort(np.linalg.eigvals(-matrix[5:, :5]).real)[2:]
    expected = np.sqrt(squares) / (2 * np.pi)
    # An unsymmetric eigenproblem: its eigenvectors' condition beside the roundings.
    assert np.allclose(at(85.0, height, condition), expected, rtol=16 * RELATIVE, atol=0)


@every_condition
@hypothesis.given(height)
def test_shapes_solve_the_eigenproblem_of_the_moving_coordinates(condition, height):
    found = all_modes(ROBOT, jnp.asarray(height), condition)
    stiffness = np.asarray(stiffness_matrix(ROBOT, jnp.asarray(height)))
    squares = np.square(2 * np.pi * np.asarray(found.frequency))
    shape = np.asarray(found.shape)
    residual = shape @ stiffness - squares[:, None] * shape * np.asarray(mass_of(condition))
    moving = residual[:, list(condition.moving)]
    # Some roundings of the largest stiffness and shape.
    assert np.max(np.abs(moving)) <= 64 * EPS * np.abs(stiffness).max() * np.abs(shape).max()


@every_condition
def test_shapes_are_mass_orthonormal_and_held_carriages_stand(condition):
    shape = np.asarray(all_modes(ROBOT, jnp.asarray(0.4), condition).shape)
    products = (shape * np.asarray(mass_of(condition))) @ shape.T
    assert np.max(np.abs(products - np.eye(condition.modes))) <= 64 * EPS
    held = [index for index in (2, 3) if index not in condition.moving]
    assert np.all(shape[:, held] == 0)


@every_condition
def test_largest_component_of_a_shape_is_positive(condition):
    shape = np.asarray(all_modes(ROBOT, jnp.asarray(0.4), condition).shape)
    assert np.all(shape.max(axis=1) == np.abs(shape).max(axis=1))


@pytest.mark.parametrize("condition", [PRINTED, DRIVEN], ids=["free", "driven"])
@hypothesis.given(height)
def test_elastic_modes_leave_the_centre_of_mass_where_it_is(condition, height):
    shape = np.asarray(all_modes(ROBOT, jnp.asarray(height), condition).shape)
    mass = np.asarray(mass_of(condition))[[0, 2, 3]]
    # Sums of three momenta.
    assert np.max(np.abs(shape[:, [0, 2, 3]] @ mass)) <= 64 * EPS * mass.max()


@hypothesis.given(height)
def test_holding_a_carriage_interlaces_the_frequencies(height):
    free = np.concatenate([[0.0], at(85.0, height, PRINTED)])
    held = at(85.0, height, LOWER_HELD)
    slack = 1 + RELATIVE
    assert np.all(free[:3] <= held * slack)
    assert np.all(held <= free[1:] * slack)


@hypothesis.given(height)
def test_the_drives_inertia_raises_no_frequency(height):
    slack = 1 + RELATIVE
    assert np.all(at(85.0, height, DRIVEN) <= at(85.0, height, PRINTED) * slack)


@hypothesis.given(height)
def test_free_robot_of_equal_carriages_is_symmetric_about_mid_height(height):
    above, below = at(85.0, height, PRINTED), at(85.0, 1.112 - height, PRINTED)
    # Heights differ by roundings of 1.112 m over paths of 0.1 m.
    assert np.allclose(above, below, rtol=16 * RELATIVE, atol=0)


@pytest.mark.parametrize(
    ("condition", "shape"),
    [(PRINTED, "peak"), (DRIVEN, "fall"), (LOWER_HELD, "fall"), (BOTH_HELD, "dip")],
    ids=["free", "driven", "held", "both held"],
)
def test_first_frequency_over_the_height_tells_the_conditions_apart(condition, shape):
    low, middle, high = (at(85.0, y, condition)[0] for y in (0.3, MIDDLE, 0.812))
    found = {
        "peak": middle > max(low, high),
        "fall": low > middle > high,
        "dip": middle < min(low, high),
    }
    assert found[shape]


def test_single_precision_is_enough_for_a_map():
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), ROBOT)
    heights = jnp.linspace(0.2, 0.9, 50)
    mapped = jax.jit(jax.vmap(natural_frequencies, in_axes=(None, 0, None)))
    double = mapped(ROBOT, heights, DRIVEN)
    error = mapped(single, heights.astype(jnp.float32), DRIVEN) / double.astype(jnp.float32) - 1
    assert error.dtype == jnp.float32
    # The tolerance in double precision, with single precision's rounding.
    assert jnp.max(jnp.abs(error)) <= RELATIVE / EPS * float(jnp.finfo(jnp.float32).eps)


@pytest.mark.parametrize("condition", [DRIVEN, Condition(Lower.HELD, Upper.HELD)])
def test_frequencies_are_differentiable_in_parameters_and_height(condition):
    def found(tension, inertia, offset, y):
        numbers = {
            "effective_pretension": 85 * tension,
            "drive_inertia": 1.27e-2 * inertia,
            "lower_offset": 0.14 * offset,
        }
        return natural_frequencies(replace(ROBOT, numbers), y, condition)

    arguments = (jnp.asarray(1.0), jnp.asarray(1.0), jnp.asarray(1.0), jnp.asarray(0.4))
    check_grads(jax.jit(found), arguments, order=1, modes=("fwd", "rev"))


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_slope_in_the_pretension_is_the_closed_form(mode):
    slope = jax.jit(mode(lambda T: frequencies(T, jnp.asarray(0.4), PRINTED)))(
        jnp.asarray(85.0)
    )
    assert np.allclose(slope, at(85.0, 0.4, PRINTED) / (2 * 85.0), rtol=RELATIVE, atol=0)
