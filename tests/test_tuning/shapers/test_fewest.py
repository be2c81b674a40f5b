import numpy as np
import pytest
from share import share

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.catalogue import zv, zvd
from tuning.shapers.design import fewest_impulses, worst_residual
from tuning.shapers.design.positive import Design

MODE = worst_residual([3.0], [0.0])


def spread_out(count):
    """A shaper of many impulses that leaves nothing of 3 Hz: ZV's, each in several parts."""
    shares = np.arange(1.0, count + 1)
    near = 1e-3 * np.arange(count)
    times = np.concatenate([near, 1 / 6 + near])
    amplitudes = np.concatenate([shares, shares])
    return Shaper(times, amplitudes / amplitudes.sum())


@pytest.mark.parametrize("count", share((4, 2, 12), 1))
def test_what_many_impulses_do_for_one_mode_two_do(count):
    many = spread_out(count)
    few = fewest_impulses(MODE, Design(many, float(MODE(many)), 0.0), bound=5e-4)
    assert few.shaper.times.size == 2
    assert few.residual <= 5e-4
    assert float(few.shaper.duration) <= float(many.duration) * (1 + 1e-9)


def test_impulses_that_are_needed_stay():
    spread = worst_residual(np.linspace(2.7, 3.3, 7), np.zeros(7))
    flat = zvd(3.0, 0.0)
    left = float(spread(flat))
    kept = fewest_impulses(spread, Design(flat, left, 0.0), bound=1.01 * left)
    assert kept.shaper.times.size == 3


def test_more_than_are_allowed_are_taken_out_at_any_price():
    spread = worst_residual(np.linspace(2.7, 3.3, 7), np.zeros(7))
    flat = zvd(3.0, 0.0)
    few = fewest_impulses(spread, Design(flat, float(spread(flat)), 0.0), bound=0.0, most=2)
    assert few.shaper.times.size == 2


def test_two_impulses_stay_as_they_are():
    best = Design(zv(3.0, 0.0), 0.0, 0.0)
    assert fewest_impulses(MODE, best, bound=1.0) is best
