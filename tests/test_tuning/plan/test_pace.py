import dataclasses

import pytest

from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.plan.leg import Leg
from tuning.plan.pace import ORDERS, PLAIN_SHARE, STRETCH, Pace

FITTED = exact(
    replace(
        consistent(),
        {
            "effective_pretension": 85.166460,
            "friction_coefficient": 0.018270845,
            "drive_inertia": 0.014530930,
            "drive_damping": 0.20129864,
        },
    )
)
PACE = Pace(FITTED)
DIAGONAL = Leg((2.08, 0.92), (0.01, 0.19), 2.0)
MOST = PLAIN_SHARE * 10.0


def test_a_leg_that_the_drives_can_do_keeps_its_time_and_the_papers_profile():
    leg = Leg((0.3, 0.55), (1.9, 0.55), 2.0)
    assert PACE.possible(leg) == leg


def test_what_the_papers_profile_can_t_do_is_done_at_an_evener_pace_in_the_shortest_time():
    leg = PACE.possible(DIAGONAL)
    assert 2.0 < leg.time < 2.5
    assert leg.order == max(ORDERS)
    assert PACE.voltage(leg) <= MOST
    shorter = dataclasses.replace(leg, time=leg.time / STRETCH)
    assert all(
        PACE.voltage(dataclasses.replace(shorter, order=order)) > MOST for order in ORDERS
    )


def test_in_a_time_in_which_no_profile_is_possible_it_is_the_one_that_asks_least():
    short = dataclasses.replace(DIAGONAL, time=1.0)
    volts = [PACE.voltage(dataclasses.replace(short, order=k)) for k in ORDERS]
    assert PACE.voltage(PACE.paced(short)) == pytest.approx(min(volts))
