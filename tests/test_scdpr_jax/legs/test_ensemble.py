import jax
import numpy as np
import pytest

from scdpr_jax.legs.ensemble import Variation, single, stacked, varied, vary, with_values
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value

ROBOT = exact(replace(consistent(), {"upper_friction_coefficient": 0.02}))
VARIATIONS = (
    Variation(weight=2.0),
    Variation(tension=1.03),
    Variation(friction=0.8),
    Variation(out_of_line=-0.3),
)
GRID = varied(ROBOT, VARIATIONS, (0.3, 0.55))


def force(robot, name):
    return float(value(robot, name)) * float(value(robot, "effective_pretension"))


@pytest.mark.parametrize("name", ["friction_coefficient", "upper_friction_coefficient"])
def test_another_tension_is_no_other_friction_force(name):
    tenser = vary(ROBOT, Variation(tension=1.03))
    assert force(tenser, name) == pytest.approx(force(ROBOT, name), rel=1e-14)
    assert force(vary(ROBOT, Variation(friction=0.8)), name) == pytest.approx(
        0.8 * force(ROBOT, name), rel=1e-14
    )


def test_the_plain_variation_is_the_fitted_robot():
    plain = vary(ROBOT, Variation())
    same = jax.tree.map(lambda a, b: bool(a == b), plain, ROBOT)
    assert all(jax.tree.leaves(same))


def test_a_grid_has_a_row_for_each_variation():
    assert len(GRID) == len(VARIATIONS)
    np.testing.assert_array_equal(GRID.weight, [2.0, 1.0, 1.0, 1.0])
    np.testing.assert_array_equal(GRID.out_of_line, [0.0, 0.0, 0.0, -0.3])
    np.testing.assert_array_equal(GRID.position, np.tile((0.3, 0.55), (4, 1)))


def test_every_robot_starts_as_it_does_alone():
    starts = jax.vmap(lambda each: each.start)(GRID)
    alone = single(ROBOT, (0.3, 0.55)).start
    np.testing.assert_allclose(starts.position[0], alone.position, atol=1e-15)
    assert float(starts.position[3, 2] - starts.position[3, 3]) < -1e-3


def test_rows_are_the_robots_of_these_numbers():
    few = GRID.rows(np.array([1, 3]))
    assert len(few) == 2
    np.testing.assert_array_equal(few.out_of_line, [0.0, -0.3])
    tension = float(ROBOT.cable.effective_pretension)
    np.testing.assert_allclose(few.robot.cable.effective_pretension, [1.03 * tension, tension])


def test_draws_of_a_posterior_make_an_ensemble():
    names = ("effective_pretension", "friction_coefficient")
    draws = np.array([[84.0, 0.017], [86.0, 0.019], [85.0, 0.018]])
    ensemble = stacked(with_values(ROBOT, names, draws), (0.5, 0.5))
    np.testing.assert_array_equal(ensemble.robot.cable.effective_pretension, draws[:, 0])
    np.testing.assert_array_equal(
        ensemble.robot.upper_carriage.friction.coefficient, draws[:, 1]
    )
