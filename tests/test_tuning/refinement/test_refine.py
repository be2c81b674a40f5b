"""Legs of rigs that are another program correct a robot that isn't quite the rig's."""

import dataclasses

import leg_rigs
import numpy as np
import pytest
from logged_legs import OFF, TRUE, logged

from scdpr_jax.robot.quantities import value
from tuning.refinement.corrections import CORRECTIONS, with_corrections
from tuning.refinement.refine import refine
from tuning.refinement.replay import NUISANCES, Replay

pytestmark = leg_rigs.needs_compiler


@pytest.fixture(scope="module")
def legs():
    return [logged(seed, f"leg-{seed}") for seed in (11, 12, 13)]


@pytest.fixture(scope="module")
def found(legs):
    return refine(OFF, legs)


@pytest.mark.parametrize(
    ("name", "bound"),
    [
        ("effective_pretension", 2e-3),
        ("upper_friction_coefficient", 0.015),
        ("torque_per_volt", 0.01),
    ],
)
def test_what_is_off_comes_nearer_to_the_rigs(found, name, bound):
    true, off, now = (float(value(robot, name)) for robot in (TRUE, OFF, found.robot))
    assert abs(now / true - 1) < bound < abs(off / true - 1)


def test_legs_left_out_are_foretold_better(found):
    assert found.is_tried
    assert found.helps
    assert all(own.foretold < own.before for own in found.legs)


def test_what_is_right_is_left_within_its_error(legs):
    again = refine(TRUE, legs)
    for own in again.corrected:
        assert abs(own.after - own.before) < 4 * own.sigma


def test_a_correction_by_legs_of_another_rig_is_not_kept(legs):
    # Frames of one leg beside the drives of another tell nothing that holds for a third.
    mixed = [
        dataclasses.replace(own, seen=np.roll(own.seen, shift, axis=0))
        for own, shift in zip(legs, (0, 25, -25), strict=True)
    ]
    assert not refine(TRUE, mixed).helps


def test_a_leg_alone_is_said_to_be_untried(legs):
    alone = refine(OFF, legs[:1])
    assert not alone.is_tried
    assert np.isnan(alone.legs[0].foretold)
    assert alone.legs[0].after < alone.legs[0].before


def test_a_log_of_another_rate_says_the_same():
    fast, slow = (refine(OFF, [logged(11, every=own)]) for own in (1, 4))
    for own, other in zip(fast.corrected, slow.corrected, strict=True):
        assert abs(own.after - other.after) < own.sigma


def test_no_leg_is_refused():
    with pytest.raises(ValueError, match="`legs` is empty"):
        refine(OFF, [])


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_differences(legs, seed):
    random = np.random.default_rng(seed)
    replay = Replay(OFF, legs[seed])
    shares, start = 0.3 * random.normal(size=len(CORRECTIONS)), np.array([1e-4, 2e-4])
    shares[3:6] = np.abs(shares[3:6])
    along = random.normal(size=len(CORRECTIONS) + NUISANCES) * ([1.0] * 7 + [1e-3, 1e-3])
    made, h = replay(shares, start), 1e-6

    def moved(by):
        own = replay(shares + by * along[:-2], start + by * along[-2:])
        return own.position, own.voltage

    for slope, ahead, behind in zip(made.slopes, moved(h), moved(-h), strict=True):
        difference = (ahead - behind) / (2 * h)
        size = np.abs(difference).max(axis=0)
        # Where a contact comes or goes between both, a difference stands beside a kink.
        near = np.abs(slope @ along - difference) <= 1e-4 * size
        assert np.mean(near) > 0.98


def test_no_correction_changes_nothing():
    same = with_corrections(OFF, np.zeros(len(CORRECTIONS)))
    for own in CORRECTIONS:
        assert float(value(same, own.name)) == float(value(OFF, own.name))
