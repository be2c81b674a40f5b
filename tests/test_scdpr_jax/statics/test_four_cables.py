"""Tests of `scdpr_jax.statics.four_cables`."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from jax.test_util import check_grads

from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.statics.four_cables import needed_tension

WIDTH, HEIGHT = 2.224, 1.112
# Section 2.1's end-effector: 0.281 m wide, 0.287 m high, 2 kg; Table 1 has them exchanged.
SECTION_2_1 = replace(
    consistent(),
    {"end_effector_mass": 2.0, "lower_offset": 0.1435, "upper_offset": 0.1435},
)


@functools.partial(jax.jit, static_argnames="crossed")
def tension(robot, positions, width, minimum, gravity, *, crossed):
    def needed(position):
        return needed_tension(
            robot,
            position,
            end_effector_width=width,
            minimum_tension=minimum,
            gravity=gravity,
            crossed=crossed,
        )

    return jax.vmap(needed)(positions)


def by_linear_program(robot, position, width, minimum, gravity, *, crossed):
    """The same least largest tension from scratch, in NumPy and HiGHS."""
    lower, upper = (
        -float(robot.end_effector.lower_offset),
        float(robot.end_effector.upper_offset),
    )
    bottom, top = (upper, lower) if crossed else (lower, upper)
    corners = np.array([(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)])
    arms = np.array(
        [(-width, 2 * bottom), (width, 2 * bottom), (width, 2 * top), (-width, 2 * top)]
    )
    arms /= 2
    cables = corners - position - arms
    pull = cables / np.linalg.norm(cables, axis=1, keepdims=True)
    moment = arms[:, 0] * pull[:, 1] - arms[:, 1] * pull[:, 0]
    balance = np.column_stack([np.vstack([pull.T, moment]), np.zeros(3)])
    found = scipy.optimize.linprog(
        c=[0, 0, 0, 0, 1],
        A_eq=balance,
        b_eq=[0, float(robot.end_effector.mass) * gravity, 0],
        A_ub=np.column_stack([np.eye(4), -np.ones(4)]),
        b_ub=np.zeros(4),
        bounds=[(minimum, None)] * 4 + [(None, None)],
    )
    assert found.status in (0, 2)  # solved, or infeasible
    return found.fun if found.status == 0 else np.inf


@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_needed_tension_is_the_linear_programs(crossed, gravity):
    random = np.random.default_rng(11)
    agreed = 0
    for _ in range(60):
        robot = replace(
            consistent(),
            {
                "lower_offset": random.uniform(0.05, 0.3),
                "upper_offset": random.uniform(0.05, 0.3),
                "end_effector_mass": random.uniform(0.5, 5.0),
            },
        )
        width, minimum = random.uniform(0.1, 0.5), random.uniform(0.0, 60.0)
        position = random.uniform(0.02, 0.98, 2) * (WIDTH, HEIGHT)
        ours = float(
            tension(robot, position[None], width, minimum, gravity, crossed=crossed)[0]
        )
        theirs = by_linear_program(robot, position, width, minimum, gravity, crossed=crossed)
        # HiGHS's feasibility tolerance is 1e-7; tensions reach some 1e5 N near singular poses.
        assert ours == pytest.approx(theirs, rel=1e-5, abs=1e-5)
        agreed += np.isfinite(theirs)
    assert agreed >= 15  # both kinds of poses were among them


def frame_grid(rows):
    """Centres of cells that share the frame's area evenly."""
    across = (np.arange(2 * rows) + 0.5) / (2 * rows) * WIDTH
    up = (np.arange(rows) + 0.5) / rows * HEIGHT
    return np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)


GRID = frame_grid(300)


def share_over_the_frame(maximum, minimum, *, crossed, gravity=9.81):
    needed = tension(SECTION_2_1, GRID, 0.281, minimum, gravity, crossed=crossed)
    return float(jnp.mean(needed <= maximum))


@pytest.mark.parametrize(
    ("crossed", "minimum", "maximum", "printed"),
    [(False, 50.0, 287.0, 0.4156), (True, 10.0, 93.0, 0.7073), (True, 50.0, 151.0, 0.4156)],
)
def test_figure_3s_shares_ask_for_these_largest_tensions(crossed, minimum, maximum, printed):
    # A newton more or less moves the share across the printed one.
    below = share_over_the_frame(maximum - 1, minimum, crossed=crossed)
    above = share_over_the_frame(maximum + 1, minimum, crossed=crossed)
    assert below < printed < above


def test_open_cables_never_reach_figure_3s_larger_share():
    assert share_over_the_frame(1e9, 10.0, crossed=False) < 0.67


def test_without_gravity_figure_3s_larger_share_would_ask_for_a_third_less():
    assert share_over_the_frame(61.0, 10.0, crossed=True, gravity=0.0) > 0.7073


@pytest.mark.parametrize("crossed", [False, True])
def test_tension_is_symmetric_about_the_middle_of_the_frame(crossed):
    mirrored = GRID * (-1, 1) + (WIDTH, 0)
    here, there = (
        np.asarray(tension(consistent(), grid, 0.287, 10.0, 9.81, crossed=crossed))
        for grid in (GRID[::97], mirrored[::97])
    )
    np.testing.assert_allclose(here, there, rtol=1e-9)


def test_pose_at_the_middle_without_gravity_needs_no_more_than_the_minimum():
    middle = np.array([[WIDTH / 2, HEIGHT / 2]])
    needed = tension(consistent(), middle, 0.287, 10.0, 0.0, crossed=False)
    # Four equal tensions; the structure matrix is symmetric to a few roundings.
    np.testing.assert_allclose(needed, 10.0, rtol=1e-12)


@pytest.mark.parametrize("position", [(0.0, 0.5), (-0.1, 0.5), (1.0, 1.112), (1.0, 1.3)])
def test_centre_on_or_beyond_the_frame_needs_infinite_tension(position):
    needed = tension(consistent(), np.array([position]), 0.287, 10.0, 9.81, crossed=True)
    assert np.isposinf(needed[0])


@pytest.mark.slow
def test_needed_tension_is_differentiable_by_pose_minimum_and_gravity():
    def needed(position, minimum, gravity):
        return needed_tension(
            consistent(),
            position,
            end_effector_width=jnp.asarray(0.287),
            minimum_tension=minimum,
            gravity=gravity,
            crossed=True,
        )

    arguments = (jnp.array([0.7, 0.4]), jnp.asarray(20.0), jnp.asarray(9.81))
    check_grads(jax.jit(needed), arguments, order=1, modes=("fwd", "rev"))
