"""A loop whose tension rises as its path gets longer, and drives of unequal dry friction."""

import jax
import jax.numpy as jnp
import numpy as np

from scdpr_jax.robot.cable import lengthening, loop_forces, potential
from scdpr_jax.robot.dynamics import drive_forces, drive_friction
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

ELASTIC = replace(consistent(), {"loop_stiffness": 2600.0})
POSITION = jnp.array([0.9, 0.04, 0.95, 0.88, 0.6])


def test_an_aligned_loop_is_not_lengthened():
    aligned = jnp.array([0.7, 0.0, 0.7, 0.7, 0.4])
    assert abs(float(lengthening(ELASTIC, aligned))) < 1e-14


def test_the_pull_is_minus_the_gradient_of_the_potential_with_a_stiffness_too():
    slope = jax.grad(lambda q: potential(ELASTIC, q))(POSITION)
    np.testing.assert_allclose(loop_forces(ELASTIC, POSITION).pull, -slope, atol=1e-11)


def test_a_longer_path_pulls_the_harder():
    stretched = float(lengthening(ELASTIC, POSITION))
    ratio = loop_forces(ELASTIC, POSITION).normal / loop_forces(consistent(), POSITION).normal
    expected = 1 + 2600.0 * stretched / float(consistent().cable.effective_pretension)
    assert stretched > 1e-3
    np.testing.assert_allclose(ratio, expected, rtol=1e-12)


def test_unequal_drives_lift_what_they_only_move_aside_when_equal():
    uneven = replace(consistent(), {"drive_friction": 0.05, "drive_friction_difference": 0.02})
    even = replace(consistent(), {"drive_friction": 0.05})
    velocity = jnp.array([0.5, 0.0, 0.5, 0.5, 0.0])

    def force(robot):
        return drive_forces(robot, -drive_friction(robot, velocity))

    difference = force(uneven) - force(even)
    # Both drives turn at 6.8 rad/s, far beyond the width: friction is all there.
    np.testing.assert_allclose(difference, [0, 0, 0, 0, 0.02 / 0.073], atol=1e-12)
