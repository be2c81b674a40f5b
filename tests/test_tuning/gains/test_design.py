import hypothesis.extra.numpy as arrays
import jax
import jax.numpy as jnp
from hypothesis import given
from hypothesis import strategies as st

from tuning.gains.design import IMPULSES, LONGEST_GAP, Design, middle, shaper_of, spread_of

NUMBERS = arrays.arrays(float, IMPULSES - 1, elements=st.floats(-20, 20))


@given(NUMBERS, NUMBERS)
def test_whatever_the_numbers_the_shaper_is_one_of_positive_impulses(gaps, amplitudes):
    shaper = shaper_of(Design(jnp.zeros(2), jnp.asarray(gaps), jnp.asarray(amplitudes)))
    assert abs(float(jnp.sum(shaper.amplitudes)) - 1) <= 8 * jnp.finfo(float).eps
    assert jnp.all(shaper.amplitudes > 0)
    assert float(shaper.times[0]) == 0
    assert jnp.all(jnp.diff(shaper.times) >= 0)
    assert float(shaper.duration) <= (IMPULSES - 1) * LONGEST_GAP * (1 + 1e-12)


def test_the_spread_has_a_row_for_every_number_of_a_design():
    for impulses in (2, 4, 6):
        flat, _ = jax.flatten_util.ravel_pytree(middle(impulses))
        assert spread_of(impulses).shape == (flat.size, flat.size)
