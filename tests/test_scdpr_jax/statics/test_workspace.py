import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.statics.workspace import frame_share, reachable_share, static_workspace

EPS = float(np.finfo(float).eps)
ROBOT = consistent()
WIDTH = jnp.asarray(0.287)
offset = st.floats(0.01, 0.4)


def with_carriages(lower, upper):
    return eqx.tree_at(
        lambda r: (r.lower_carriage.width, r.upper_carriage.width),
        ROBOT,
        (jnp.asarray(lower), jnp.asarray(upper)),
    )


def test_workspace_of_table_1_is_65_percent_of_the_frame():
    share = float(frame_share(ROBOT))
    # (2224 - 287)(1112 - 281) / (2224 * 1112), a few roundings.
    assert abs(share - 1937 * 831 / (2224 * 1112)) <= 16 * EPS
    assert round(100 * share, 1) == 65.1


def test_workspace_of_table_1_is_less_than_the_conventional_robots_best():
    assert frame_share(ROBOT) < 0.7073


def test_robot_has_every_geometrically_reachable_position():
    assert reachable_share(ROBOT, end_effector_width=WIDTH) == 1


def test_wider_carriages_take_from_the_reachable_positions():
    share = reachable_share(with_carriages(0.4, 0.287), end_effector_width=WIDTH)
    assert abs(float(share) - (2.224 - 0.4) / (2.224 - 0.287)) <= 16 * EPS


def test_carriages_narrower_than_the_end_effector_add_nothing_reachable():
    share = reachable_share(with_carriages(0.1, 0.1), end_effector_width=WIDTH)
    assert abs(float(share) - 1) <= 16 * EPS


def test_either_carriage_may_be_the_wider_one():
    first, second = with_carriages(0.4, 0.2), with_carriages(0.2, 0.4)
    assert eqx.tree_equal(static_workspace(first), static_workspace(second))


@hypothesis.given(lower=offset, upper=offset)
def test_both_attachments_stay_inside_the_frame(lower, upper):
    robot = replace(ROBOT, {"lower_offset": lower, "upper_offset": upper})
    region = static_workspace(robot)
    assert abs(float(region.lowest[1]) - lower) <= EPS
    assert abs(float(region.highest[1]) - (1.112 - upper)) <= 2 * EPS


def test_equation_1_with_its_printed_letters_leaves_the_frame():
    # Printed: b below, H - a above, with section 2.3's a the upper offset; the letters of
    # Eqs. (4)-(20) in it put the lower attachment below the frame.
    robot = replace(ROBOT, {"lower_offset": 0.2, "upper_offset": 0.1})
    printed = jnp.array([1.0, float(robot.end_effector.upper_offset)])
    assert printed[1] - robot.end_effector.lower_offset < 0
    assert not static_workspace(robot).contains(printed)


@pytest.mark.parametrize(
    ("position", "inside"),
    [
        ((0.1435, 0.1405), True),
        ((1.0, 0.5), True),
        ((0.1434, 0.5), False),
        ((2.0806, 0.5), False),
        ((1.0, 0.1404), False),
        ((1.0, 0.9716), False),
    ],
)
def test_border_belongs_to_the_workspace_and_beyond_it_does_not(position, inside):
    assert bool(static_workspace(ROBOT).contains(jnp.array(position))) is inside


def test_table_3s_diagonal_leaves_the_workspace():
    assert not static_workspace(ROBOT).contains(jnp.array([0.01, 0.19]))


def test_workspace_of_a_frame_too_low_for_the_end_effector_is_empty():
    assert frame_share(replace(ROBOT, {"frame_height": 0.2})) == 0


def test_share_is_differentiable_in_frame_and_offsets():
    def share(width, height, lower):
        numbers = {"frame_width": width, "frame_height": height, "lower_offset": lower}
        return frame_share(replace(ROBOT, numbers))

    arguments = (jnp.asarray(2.2), jnp.asarray(1.1), jnp.asarray(0.15))
    check_grads(jax.jit(share), arguments, order=1, modes=("fwd", "rev"))
