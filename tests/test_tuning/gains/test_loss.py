import numpy as np
import pytest

from tuning.gains.loss import loss, ratios
from tuning.result.prediction import LegsOutcome

LEGS = 4
BEFORE = LegsOutcome(np.full(LEGS, 4e-3), np.full(LEGS, 4e-3))


def changed(*, vibration=1.0, resting_error=1.0):
    return LegsOutcome(BEFORE.vibration * vibration, BEFORE.resting_error * resting_error)


def test_the_plain_profile_loses_nothing():
    assert loss(BEFORE, BEFORE) == 0


def test_half_of_the_vibration_is_the_logarithm_of_a_half():
    assert loss(changed(vibration=0.5), BEFORE) == pytest.approx(np.log(0.5))


def test_a_leg_that_shakes_twice_as_much_isnt_made_up_for_by_one_that_shakes_half():
    mixed = changed(vibration=np.array([0.5, 2.0, 1.0, 1.0]))
    assert loss(mixed, BEFORE) > 0.4


def test_vibration_isnt_bought_with_a_resting_error_that_doubles():
    assert loss(changed(vibration=0.1, resting_error=2.0), BEFORE) > 0


def test_a_vibration_that_nobody_sees_counts_as_the_least_that_one_does():
    both = (
        ratios(changed(vibration=1e-6), BEFORE),
        ratios(changed(vibration=1e-3), BEFORE),
    )
    np.testing.assert_array_equal(*both)


def test_many_laws_are_judged_at_once():
    many = changed(vibration=np.array([[0.5], [0.8], [1.0]]), resting_error=np.ones((3, 1)))
    np.testing.assert_allclose(loss(many, BEFORE), np.log([0.5, 0.8, 1.0]))
