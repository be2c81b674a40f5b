import hypothesis.extra.numpy as arrays
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scdpr_jax.legs.draws import NormalErrors, root_of

ERRORS = NormalErrors(
    ("effective_pretension", "friction_coefficient", "drive_inertia"),
    np.array([85.0, 0.018, 0.0145]),
    np.array([0.85, 0.00018, 0.0]),
    np.array([[1.0, -0.8, 0.0], [-0.8, 1.0, 0.0], [0.0, 0.0, 1.0]]),
)
DRAWN = ERRORS.draw(400, seed=3)


def test_draws_have_the_standard_errors():
    # 400 draws: standard errors to 3.5 %, three times that at the most.
    np.testing.assert_allclose(DRAWN[:, :2].std(axis=0) / (0.85, 0.00018), 1.0, atol=0.11)


def test_draws_are_correlated():
    assert abs(np.corrcoef(DRAWN[:, :2].T)[0, 1] + 0.8) < 0.06


def test_what_has_no_error_keeps_its_value():
    assert set(DRAWN[:, 2]) == {0.0145}


def test_a_positive_quantity_stays_positive_and_a_signed_one_need_not():
    names = ("drive_friction", "drive_friction_difference")
    wide = NormalErrors(names, np.array([0.01, 0.01]), np.array([0.1, 0.1]), np.eye(2))
    friction, difference = wide.draw(200, seed=0).T
    assert friction.min() > 0
    assert difference.min() < 0


@given(arrays.arrays(float, (3, 3), elements=st.floats(-2, 2)))
def test_the_root_of_a_covariance_gives_it_back(factor):
    covariance = factor @ factor.T
    root = root_of(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)
