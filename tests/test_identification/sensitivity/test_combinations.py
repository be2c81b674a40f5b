"""Combinations by rank: what is told, and what no smaller noise tells."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from identification.sensitivity.combinations import SHARE, Combination, combinations

NAMES = (("friction_coefficient", None), ("torque_per_volt", None), ("drive_inertia", None))


def told(information):
    return combinations(np.asarray(information, dtype=float), NAMES)


def test_a_product_that_alone_is_seen_leaves_the_ratio_untold():
    product = np.array([1.0, 1.0, 0.0])
    found = told(1e4 * np.outer(product, product) + np.diag([0.0, 0.0, 1e4]))
    worst = found[-1]
    assert np.isinf(worst.sigma)
    # The direction in which the product stays: one rises as the other falls.
    np.testing.assert_allclose(np.abs(worst.powers), [0.5**0.5, 0.5**0.5, 0.0], atol=1e-9)
    assert "rising while" in worst.text()


def test_a_combination_is_as_sharp_as_its_information():
    found = told(np.diag([1e4, 1e2, 1.0]))
    np.testing.assert_allclose([one.sigma for one in found], [0.01, 0.1, 1.0])
    assert found[0].text() == "friction coefficient by itself"


@given(noise=st.floats(1e-12, 1e-3))
def test_what_moves_less_than_its_share_is_not_told_however_small_the_noise(noise):
    sizes = np.array([1.0, 2 * SHARE, 0.5 * SHARE])
    found = combinations(np.diag((sizes / noise) ** 2), NAMES, motion=1 / noise)
    np.testing.assert_allclose([one.share for one in found], sizes)
    assert [one.is_told for one in found] == [
        True,
        noise / sizes[1] < 0.1,
        False,
    ]


def test_a_single_quantity_that_falls_falls():
    one = Combination((("coulomb", None), ("offset", None)), (0.5**0.5, -(0.5**0.5)), 1.0)
    assert one.text() == "coulomb rising while offset falls"
