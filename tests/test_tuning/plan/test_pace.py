import numpy as np

from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.plan.pace import ORDERS, Pace, chosen_pace

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
START, END = (0.3, 0.55), (1.9, 0.55)


def test_a_leg_that_the_drives_can_do_in_two_seconds_takes_two():
    pace = chosen_pace(FITTED, np.array(START), np.array(END), None)
    assert pace == Pace(2.0, 2)


def test_what_the_papers_profile_can_t_do_in_two_seconds_is_done_at_an_evener_pace():
    """Table 3's diagonal takes the paper's profile to the limit at 2.5 s a leg already."""
    ends = np.array([2.08, 0.92]), np.array([0.01, 0.19])
    pace = chosen_pace(FITTED, *ends, None)
    assert 2.0 < pace.leg_time < 2.5
    assert pace.order == max(ORDERS)
    # At a time that is asked for it is the paper's where the drives can follow it.
    assert chosen_pace(FITTED, *ends, 4.0) == Pace(4.0, 2)
    assert chosen_pace(FITTED, *ends, 1.0) == Pace(1.0, max(ORDERS))
