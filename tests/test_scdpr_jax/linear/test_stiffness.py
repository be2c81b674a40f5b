import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.linear.model import stiffness_matrix
from scdpr_jax.linear.modes import BOTH_HELD, CONDITIONS, LOWER_HELD, PRINTED
from scdpr_jax.linear.stiffness import cable_lengths, four_cable_stiffness, horizontal_stiffness
from scdpr_jax.robot.loop_elasticity import CableSection, consistent_section
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.statics.four_cables import least_tensions, needed_tension

EPS = float(np.finfo(float).eps)
ROBOT = consistent()
WIDTH = jnp.asarray(0.287)
MIDDLE = jnp.asarray([1.112, 0.556])
FLAT = replace(ROBOT, {"lower_offset": 0.0, "upper_offset": 0.0})


def stiffness(robot, position, tensions, *, crossed=False, width=WIDTH, section=None):
    return four_cable_stiffness(
        robot,
        position,
        end_effector_width=width,
        tensions=tensions,
        section=section or consistent_section(),
        crossed=crossed,
    )


def test_held_carriages_make_two_strings_at_mid_height():
    # By symmetry the end-effector doesn't turn there.
    expected = 2 * 85.0 * 2 / (0.556 - 0.1405)
    found = horizontal_stiffness(ROBOT, jnp.asarray(0.556), BOTH_HELD)
    assert abs(float(found) - expected) <= 64 * EPS * expected


def test_free_carriages_hold_nothing():
    assert horizontal_stiffness(ROBOT, jnp.asarray(0.4), PRINTED) == 0


def test_whole_push_moves_everything_that_gives_way():
    height, force = jnp.asarray(0.4), 3.0
    moving = np.array(LOWER_HELD.moving)
    matrix = np.asarray(stiffness_matrix(ROBOT, height))[np.ix_(moving, moving)]
    moved = np.linalg.solve(matrix, [force, 0.0, 0.0])[0]
    found = horizontal_stiffness(ROBOT, height, LOWER_HELD)
    # A solve of a matrix whose condition is a few hundred.
    assert abs(float(found) * moved - force) <= 1e4 * EPS * force


@pytest.mark.parametrize("condition", CONDITIONS)
def test_stiffness_is_proportional_to_the_tension(condition):
    height = jnp.asarray(0.7)
    twice = replace(ROBOT, {"effective_pretension": 170.0})
    single = horizontal_stiffness(ROBOT, height, condition)
    double = horizontal_stiffness(twice, height, condition)
    assert jnp.abs(double - 2 * single) <= 1e4 * EPS * (1 + jnp.abs(double))


def test_four_cables_to_a_point_in_the_middle_have_a_known_stiffness():
    tension, section = 50.0, consistent_section()
    point = stiffness(FLAT, MIDDLE, jnp.full(4, tension), width=jnp.asarray(0.0))
    length = np.hypot(1.112, 0.556)
    along = (float(section.axial_stiffness) + tension) / length
    cos, sin = 1.112 / length, 0.556 / length
    expected = 4 * np.array(
        [along * cos**2 + tension / length * sin**2, along * sin**2 + tension / length * cos**2]
    )
    # A Hessian by differentiation: some hundred roundings.
    assert np.allclose(np.diag(point)[:2], expected, rtol=500 * EPS)


def test_slack_elasticity_leaves_the_tension_alone():
    soft = CableSection(modulus=1e-3, diameter=2e-3)
    tensions = jnp.full(4, 50.0)
    hard = stiffness(ROBOT, MIDDLE, tensions)
    assert stiffness(ROBOT, MIDDLE, tensions, section=soft)[0, 0] < 1e-2 * hard[0, 0]


def test_crossing_changes_lengths_but_for_a_point():
    def lengths(robot, width, crossed):
        pose = jnp.asarray([0.9, 0.4, 0.1])
        return cable_lengths(robot, pose, end_effector_width=width, crossed=crossed)

    point = jnp.asarray(0.0)
    assert jnp.array_equal(lengths(FLAT, point, True), lengths(FLAT, point, False))
    assert not jnp.allclose(lengths(ROBOT, WIDTH, True), lengths(ROBOT, WIDTH, False))


def least(position, crossed, minimum=10.0):
    return least_tensions(
        ROBOT,
        position,
        end_effector_width=WIDTH,
        minimum_tension=jnp.asarray(minimum),
        gravity=jnp.asarray(9.81),
        crossed=crossed,
    )


@pytest.mark.parametrize("crossed", [False, True])
def test_least_tensions_balance_the_weight_at_the_minimum(crossed):
    position = jnp.asarray([0.8, 0.5])
    tensions = least(position, crossed)
    pulls = -jax.jacobian(
        lambda pose: cable_lengths(ROBOT, pose, end_effector_width=WIDTH, crossed=crossed)
    )(jnp.append(position, 0.0)).T
    # A pseudo-inverse: some hundred roundings of the largest tension.
    tolerance = 500 * EPS * float(tensions.max())
    assert np.allclose(pulls @ tensions, [0.0, 2.1 * 9.81, 0.0], atol=tolerance)
    assert abs(float(tensions.min()) - 10.0) <= tolerance


@pytest.mark.parametrize("crossed", [False, True])
def test_needed_tension_is_no_more_than_the_least_tensions_largest(crossed):
    position = jnp.asarray([0.8, 0.5])
    needed = needed_tension(
        ROBOT,
        position,
        end_effector_width=WIDTH,
        minimum_tension=jnp.asarray(10.0),
        gravity=jnp.asarray(9.81),
        crossed=crossed,
    )
    assert needed <= least(position, crossed).max() * (1 + 500 * EPS)
