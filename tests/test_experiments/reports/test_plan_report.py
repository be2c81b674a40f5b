"""A planned leg in the terminal and as a page."""

import jax.numpy as jnp
import numpy as np
import pytest

from experiments.reports.plan_report import plan_page, sentences, tables
from experiments.studies.legs.planned_leg import compare
from experiments.verbs.tuning.plan import plan
from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.engines.closed_loop import closed_loop, joint_references
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import pose, rest
from tuning.plan.expectation import ROBOTS, Expectation
from tuning.plan.leg import Leg
from tuning.plan.plan import Plan
from tuning.plan.planning import Planned

ROBOT = exact(consistent())
LIMIT = float(ROBOT.drive.voltage_limit)
TIME = 1e-3 * np.arange(301)


@pytest.fixture(scope="module")
def short():
    """The plain profile itself as a plan, of 5 cm in 0.3 s."""
    leg = rest_to_rest((1.0, 0.5), (1.05, 0.5), duration=0.3)
    led = jnp.stack([leg.position(time) for time in jnp.asarray(TIME)])
    angle = np.asarray(joint_references(ROBOT, led))
    plan = Plan(TIME, np.asarray(led), angle, np.zeros((TIME.size, 2)))
    left, nothing = (Expectation(np.full(7, own), np.zeros(7)) for own in (1.0, 0.0))
    return Planned(Leg((1.0, 0.5), (1.05, 0.5), 0.3), plan, plan, 0.3, nothing, left)


@pytest.fixture(scope="module")
def compared(short):
    return compare(ROBOT, published_pd(), short)


def test_what_is_planned_plainly_does_what_the_plain_profile_does(compared):
    for plain, planned in zip(compared.plain, compared.planned, strict=True):
        np.testing.assert_allclose(planned.pose, plain.pose, atol=1e-9)


def test_the_first_robot_is_the_fitted_one(short, compared):
    held = jnp.pad(jnp.asarray(short.plan.position), ((0, 1700), (0, 0)), mode="edge")
    start = rest(ROBOT, *jnp.asarray([1.0, 1.0, 0.5]))
    alone = closed_loop(ROBOT, start, published_pd(), reference=held).states.position
    np.testing.assert_allclose(compared.plain[0].pose, pose(alone), atol=1e-12)


def test_every_robot_of_the_planner_is_named_and_differs(compared):
    assert compared.names[0] == "as fitted"
    assert "pretension −3 %" in compared.names
    assert "friction +20 %" in compared.names
    assert len(set(compared.names)) == len(ROBOTS)
    ends = {float(run.pose[-1, 0]) for run in compared.plain}
    assert len(ends) == len(ROBOTS)


def test_a_saturated_drive_is_told(short, compared):
    worst = max(run.measures.largest_voltage for run in compared.planned)
    assert not any("SHORT" in line for line in sentences(short, compared, voltage_limit=LIMIT))
    assert any("SHORT" in line for line in sentences(short, compared, voltage_limit=worst))


def test_the_page_has_every_robot_and_loads_nothing(short, compared):
    page = plan_page(short, compared, robot=ROBOT, tuning="<b>tuning</b>")
    assert all(name in page for name in compared.names)
    assert all(cell in page for table in tables(compared) for row in table.rows for cell in row)
    assert "&lt;b&gt;tuning" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert "<script" not in page


def test_a_page_in_place_of_the_table_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"such as .*plan\.csv"):
        plan(tmp_path / "tuning.json", tmp_path / "plan.html", "0.3 m, 0.55 m", "1.9 m, 0.55 m")
