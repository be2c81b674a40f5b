import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tuning.gains.design import (
    LARGEST_TAIL,
    LONGEST,
    SPREAD,
    Design,
    searched_from,
    shaper_of,
)

NUMBER = st.floats(-20, 20)


@given(NUMBER, NUMBER, NUMBER, NUMBER)
def test_whatever_the_numbers_the_shaper_is_two_impulses_and_a_small_last_one(
    gap, other_gap, first, tail
):
    shaper = shaper_of(
        Design(jnp.zeros(2), jnp.array([gap, other_gap]), jnp.asarray(first), jnp.asarray(tail))
    )
    assert abs(float(jnp.sum(shaper.amplitudes)) - 1) <= 8 * jnp.finfo(float).eps
    assert jnp.all(shaper.amplitudes[:2] >= 0)
    assert abs(float(shaper.amplitudes[2])) <= LARGEST_TAIL
    assert float(shaper.times[0]) == 0
    assert jnp.all(jnp.diff(shaper.times) >= 0)
    assert float(shaper.duration) <= LONGEST * (1 + 1e-12)


@given(st.floats(0.3, 30.0))
def test_a_search_begins_with_impulses_a_period_apart_where_that_is_searched(frequency):
    times = np.asarray(shaper_of(searched_from(frequency)).times)
    assert times[1] <= 1.1 / frequency + 0.07
    assert abs(times[1] - 1.1 / frequency) < 1e-9 or not 2.1 < frequency < 17


def test_every_number_of_a_design_has_a_spread():
    assert all(np.all(np.asarray(leaf) > 0) for leaf in (SPREAD.loop, SPREAD.gaps, SPREAD.tail))
    assert SPREAD.first > 0
