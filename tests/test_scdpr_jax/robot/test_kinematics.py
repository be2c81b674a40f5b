import hypothesis
import jax
import jax.numpy as jnp
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.kinematics import forward_kinematics, inverse_kinematics

RADIUS = jnp.asarray(0.073)
ANGLE_LIMIT = 100.0  # rad: the frame's width is 30 rad of roll
angle = st.floats(-ANGLE_LIMIT, ANGLE_LIMIT)
radius = st.floats(0.005, 0.2)


def printed_inverse(displacement, pulley_radius):
    horizontal, vertical = displacement
    return jnp.stack([horizontal - vertical, horizontal + vertical]) / pulley_radius


@hypothesis.given(first=angle, second=angle, pulley_radius=radius)
def test_inverse_kinematics_inverts_forward_kinematics(first, second, pulley_radius):
    angles = jnp.array([first, second])
    displacement = forward_kinematics(angles, jnp.asarray(pulley_radius))
    error = inverse_kinematics(displacement, jnp.asarray(pulley_radius)) - angles
    # Two roundings a component: a few ulp of the largest angle.
    assert jnp.max(jnp.abs(error)) <= 8 * jnp.finfo(angles.dtype).eps * ANGLE_LIMIT


@hypothesis.given(x=st.floats(-2.2, 2.2), y=st.floats(-1.1, 1.1), pulley_radius=radius)
def test_forward_kinematics_inverts_inverse_kinematics(x, y, pulley_radius):
    displacement = jnp.array([x, y])
    angles = inverse_kinematics(displacement, jnp.asarray(pulley_radius))
    error = forward_kinematics(angles, jnp.asarray(pulley_radius)) - displacement
    # A few ulp of the sum of the frame's width and height.
    assert jnp.max(jnp.abs(error)) <= 8 * jnp.finfo(displacement.dtype).eps * 3.3


def test_printed_inverse_does_not_invert_forward_kinematics():
    angles = jnp.array([1.0, 0.5])
    wrong = printed_inverse(forward_kinematics(angles, RADIUS), RADIUS)
    # It exchanges the two rolls: half a radian of error on each.
    assert jnp.min(jnp.abs(wrong - angles)) > 0.4


def test_printed_inverse_lifts_the_end_effector_with_a_negative_first_torque():
    up = jnp.array([0.0, 0.687])
    # Experiment 3 of Table 2: the torques are [+, -], and the end-effector rises from 0.234 m.
    assert inverse_kinematics(up, RADIUS)[0] > 0 > inverse_kinematics(up, RADIUS)[1]
    assert printed_inverse(up, RADIUS)[0] < 0 < printed_inverse(up, RADIUS)[1]


def test_equal_rolls_move_the_end_effector_horizontally_by_the_arc():
    moved = forward_kinematics(jnp.array([2.0, 2.0]), RADIUS)
    assert jnp.array_equal(moved, jnp.array([2.0 * 0.073, 0.0]))


def test_kinematics_are_differentiable_in_angles_and_radius():
    for function in (forward_kinematics, inverse_kinematics):
        check_grads(
            jax.jit(function), (jnp.array([1.2, -0.4]), RADIUS), order=1, modes=("fwd", "rev")
        )
