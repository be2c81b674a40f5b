import jax.numpy as jnp
import numpy as np

from scdpr_jax.command.controller import published_pd
from scdpr_jax.engines.closed_loop import joint_references
from scdpr_jax.robot.prototype import consistent
from tuning.plan.plan import Plan

ROBOT = consistent()
DRIVEN = np.linspace([0.3, 0.55], [0.7, 0.65], 401)
PLAN = Plan(
    1e-3 * np.arange(401),
    DRIVEN + 0.01,
    np.asarray(joint_references(ROBOT, jnp.asarray(DRIVEN))),
    np.linspace([8.0, -4.0], [0.5, 0.25], 401),
)


def test_the_drives_are_led_from_the_plans_begin_by_its_angles():
    np.testing.assert_allclose(PLAN.driven(ROBOT), DRIVEN + 0.01, atol=1e-14)


def test_the_last_row_is_held_and_judged_as_rest():
    commands = PLAN.commands(ROBOT, published_pd(), rest=0.2)
    assert commands.commanded.shape == (601, 2)
    assert list(np.flatnonzero(commands.afterwards)) == list(range(400, 601))
    np.testing.assert_array_equal(commands.feedforward[400:], np.tile([0.5, 0.25], (201, 1)))
    np.testing.assert_array_equal(commands.reference[-1], PLAN.position[-1])


def test_a_plan_says_from_where_to_where_in_which_time():
    text = repr(PLAN)
    assert "(0.31 m, 0.56 m) to (0.71 m, 0.66 m) in 0.4 s" in text
    assert "8 V" in text
    assert len(text.splitlines()) == 3
