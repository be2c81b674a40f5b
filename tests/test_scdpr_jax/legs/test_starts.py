import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scdpr_jax.engines.stepping import Inputs, step
from scdpr_jax.legs.starts import even_shares, rest_out_of_line
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

ROBOT = exact(replace(consistent(), {"friction_coefficient": 0.018}))
PLACE = jnp.asarray([0.9, 0.6])


@given(st.floats(-1.0, 1.0), st.floats(0.2, 2.0), st.floats(0.2, 0.9))
def test_the_end_effector_rests_where_it_is_asked_to(share, x, y):
    position = rest_out_of_line(ROBOT, jnp.asarray([x, y]), jnp.asarray(share)).position
    # Some roundings of 2 m.
    assert float(position[0]) == pytest.approx(x, abs=4e-15)
    assert float(position[4]) == y


@given(st.floats(-1.0, 1.0))
def test_the_lines_slope_is_the_share_of_what_friction_holds(share):
    position = rest_out_of_line(ROBOT, PLACE, jnp.asarray(share)).position
    slope = (position[2] - position[3]) / ROBOT.frame.height
    assert float(slope) == pytest.approx(0.018 * share, abs=1e-15)


@pytest.mark.parametrize(("share", "held"), [(-0.95, True), (0.95, True), (1.05, False)])
def test_friction_holds_what_is_within_its_reach_and_nothing_beyond(share, held):
    start = rest_out_of_line(ROBOT, PLACE, jnp.asarray(share))
    still = Inputs(jnp.asarray(0.01), jnp.zeros(2), jnp.zeros(()))
    velocity = step(ROBOT, start, still).velocity
    assert bool(jnp.all(velocity[jnp.asarray((2, 3))] == 0)) == held


def test_the_carriage_of_the_lesser_friction_decides():
    slippery = replace(ROBOT, {"upper_friction_coefficient": 0.009})
    start = rest_out_of_line(slippery, PLACE, jnp.asarray(1.0))
    slope = (start.position[2] - start.position[3]) / ROBOT.frame.height
    assert float(slope) == pytest.approx(0.009)


@given(st.integers(8, 500))
def test_even_shares_leave_no_gap(count):
    shares = np.sort(even_shares(count))
    assert shares[0] >= -1
    assert shares[-1] <= 1
    # Gaps of multiples of the golden ratio: 1 + its inverse square of the mean at most, here
    # with the ends, and 2 is the interval's length.
    assert np.max(np.diff(np.concatenate([[-1.0], shares, [1.0]]))) <= 2 * 2.7 / count
