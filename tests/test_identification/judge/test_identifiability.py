import numpy as np
import pytest

from identification.judge.identifiability import Identifiability
from identification.sensitivity.combinations import Combination

NAMES = (("friction_coefficient", None), ("torque_per_volt", None), ("drive_inertia", None))


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
