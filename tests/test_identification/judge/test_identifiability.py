import numpy as np
import pytest

from identification.judge.identifiability import Combination, Identifiability, _combinations

NAMES = (("friction_coefficient", None), ("torque_per_volt", None), ("drive_inertia", None))


def told(information):
    return _combinations(np.asarray(information, dtype=float), NAMES)


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


def sample(moved, alone, combinations):
    count = len(NAMES)
    return Identifiability(
        names=NAMES,
        runs=("0001-torque-step",),
        moved=np.asarray(moved, dtype=float).reshape(1, 2, count),
        alone=np.asarray(alone, dtype=float),
        together=np.ones(count),
        combinations=combinations,
    )


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "friction_coefficient",
            "Nothing in the logs depends on the friction coefficient",
        ),
        ("torque_per_volt", "can't tell torque per volt and drive inertia rising together"),
        ("drive_inertia", "hardly moves anything"),
    ],
)
def test_the_reason_tells_no_effect_from_a_weak_one_and_from_a_shared_one(name, expected):
    shared = Combination(NAMES, (0.0, 0.5**0.5, 0.5**0.5), 2.0)
    found = sample([0, 5, 0.1, 0, 7, 0.1], [np.inf, 1e-3, 0.5], (shared,))
    assert expected in found.reason(name, None)
