import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scdpr_jax.legs.share import COUNTS, share, worse

PLAIN = np.array([4e-3, 2e-3, 0.1e-3, 8e-3])


@given(st.floats(0.01, 3.0))
def test_the_same_ratio_on_every_leg_is_the_share(ratio):
    assert share(ratio * PLAIN, PLAIN) == pytest.approx(ratio)


def test_a_leg_that_the_plain_profile_doesnt_shake_doesnt_count():
    shaken = PLAIN * np.array([0.5, 0.5, 30.0, 0.5])
    assert share(shaken, PLAIN) == pytest.approx(0.5)
    assert share(np.full(2, 1e-3), np.full(2, COUNTS / 2)) == 1


def test_a_leg_is_worse_where_it_shakes_visibly_and_more():
    # More and visible; more but invisible; hardly more.
    now = np.array([5e-3, 1e-3, 0.4e-3, 8.1e-3])
    assert worse(now, PLAIN) == 0.25


def test_many_laws_have_a_share_each():
    many = np.stack([PLAIN, PLAIN / 2])
    np.testing.assert_allclose(share(many, np.stack([PLAIN] * 2)), [1.0, 0.5])
