import dataclasses

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


def test_what_the_rank_leaves_open_is_named_beside_what_the_noise_hides():
    told = Combination(NAMES, (1.0, 0.0, 0.0), 1e-9, share=0.5)
    flat = Combination(NAMES, (0.0, 0.5**0.5, -(0.5**0.5)), 1e-6, share=1e-5)
    found = dataclasses.replace(sample([1] * 6, [1e-3] * 3, (told,)), unranked=(flat,))
    assert found.open_by_rank == {NAMES[1], NAMES[2]}
    assert found.undetermined() == (flat,)
    reason = found.reason("drive_inertia", None)
    assert "can't tell torque per volt rising while drive inertia falls" in reason


def test_a_part_in_what_the_rank_leaves_open_is_left_open_by_as_much():
    flat = Combination(NAMES, (0.996, 0.0, -0.09), 1e-6, share=1e-5)
    found = dataclasses.replace(
        sample([1] * 6, [1e-3] * 3, ()), unranked=(flat,), plausible=(0.02, 1.0, 1.0)
    )
    assert found.left_open() == {NAMES[0]: pytest.approx(0.01992), NAMES[2]: 0.09}
    assert sample([1] * 6, [1e-3] * 3, ()).left_open() == {}
