"""A hundred drawn robots: the right minimum from default starts, and honest intervals."""

import pytest

from experiments.virtual_rig.recovery import DRAWN, recovered

CAMPAIGNS = 100


@pytest.fixture(scope="module")
def found():
    return [recovered(seed) for seed in range(CAMPAIGNS)]


@pytest.mark.slow
def test_99_of_100_end_in_the_right_minimum_from_default_starts(found):
    assert sum(one.right for one in found) >= 0.99 * CAMPAIGNS


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_95_percent_intervals_hold_the_truth_in_90_to_98_percent(found, name):
    right = [one for one in found if one.right]
    assert 0.90 <= sum(one.covered[name] for one in right) / len(right) <= 0.98
