import types

import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import value
from tuning.regions.cells import cells_of, other_modes, robot_in

ROBOT = consistent()


def knocks(*rows):
    columns = np.array(rows, dtype=float).T
    names = ("x", "y", "pretension", "frequency", "frequency_sigma", "damping_ratio")
    return types.SimpleNamespace(**dict(zip(names, columns, strict=True)))


RIG = knocks(
    (0.55, 0.54, 350, 3.145, 1e-3, 0.0),
    (1.11, 0.56, 350, 3.143, 1e-3, 0.0),
    (1.12, 0.87, 350, 3.96, 5e-3, 0.004),
    (1.65, 0.30, 350, 3.64, 9e-3, 0.007),
)


@pytest.mark.parametrize("x", [0.0, 0.83, 2.2])
@pytest.mark.parametrize("y", [0.0, 0.6, 1.1])
def test_every_pose_of_the_frame_lies_in_a_cell(x, y):
    cells = cells_of(RIG, ROBOT, pretension=350.0)
    assert any(cell.region.contains(x, y, 350.0) for cell in cells)


def test_every_knock_is_in_a_measured_cell_and_the_rest_is_the_models():
    cells = cells_of(RIG, ROBOT, pretension=350.0)
    assert (len(cells), sum(cell.measured for cell in cells)) == (9, 4)


def test_knocks_in_one_cell_are_averaged_by_their_weights():
    two = knocks((1.0, 0.5, 350, 3.0, 1e-3, 0.0), (1.0, 0.5, 350, 4.0, 2e-3, 0.0))
    (cell,) = cells_of(two, ROBOT, pretension=350.0)
    # Weights 4 : 1; a handful of roundings of a number near 3.
    assert abs(cell.frequency - 3.2) <= 1e-14


def test_a_knock_that_rings_in_the_rotation_is_no_measurement_of_the_sway():
    sway, rotation = natural_frequencies(ROBOT, jnp.asarray(0.5), BOTH_HELD)
    two = knocks(
        (1.0, 0.5, 350, 1.03 * float(sway), 1e-3, 0.0),
        (1.0, 0.5, 350, 0.97 * float(rotation), 1e-4, 0.01),
    )
    (cell,) = cells_of(two, ROBOT, pretension=350.0)
    assert cell.frequency == pytest.approx(1.03 * float(sway), rel=1e-12)
    assert other_modes(two, ROBOT, pretension=350.0) == (1,)


def test_the_robot_in_a_cell_has_the_cells_frequency_and_the_same_friction_force():
    (cell,) = cells_of(knocks((1.0, 0.5, 350, 3.3, 1e-3, 0.0)), ROBOT, pretension=350.0)
    inside = robot_in(cell, ROBOT)
    frequency = natural_frequencies(inside, jnp.asarray(cell.height), BOTH_HELD)[0]
    # An eigenvalue of condition below 100, and its root.
    assert abs(float(frequency) - 3.3) <= 1e-12

    def force(robot):
        names = ("effective_pretension", "friction_coefficient")
        return float(np.prod([float(value(robot, name)) for name in names]))

    assert abs(force(inside) / force(ROBOT) - 1) <= 1e-14
