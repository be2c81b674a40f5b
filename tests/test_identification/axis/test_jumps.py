"""Counters that wrap, encoders that lose counts, and motion that is neither."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.axis.jumps import continued, jumps

TIME = 0.004 * np.arange(2000)
COUNT = 2 * math.pi / 4096


def angle(speed):
    """An angle that goes to and fro by some turns, as an encoder counts it [rad]."""
    exact = 4 * np.sin(speed * TIME) + speed * TIME
    return COUNT * np.round(exact / COUNT)


@given(speed=st.floats(0.5, 8.0))
def test_angles_that_wrap_at_a_turn_go_on(speed):
    whole = angle(speed)
    wrapped = np.mod(whole, 2 * math.pi)
    got = continued(wrapped, rotary=True)
    np.testing.assert_allclose(got.position - got.position[0], whole - whole[0], atol=1e-9)
    assert got.wraps == np.count_nonzero(np.abs(np.diff(wrapped)) > math.pi)


@pytest.mark.parametrize("bits", [15, 16])
def test_counters_wrap_at_their_bits(bits):
    step = 1e-5
    counts = np.round((0.2 * np.sin(TIME) + 0.1 * TIME) / step)
    got = continued(step * np.mod(counts, 2**bits), rotary=False)
    # A quarter of the log has a wrap at least.
    assert got.wraps >= 1
    assert got.period == pytest.approx(2**bits * step)
    np.testing.assert_allclose(np.diff(got.position), np.diff(step * counts), atol=1e-9)


@given(speed=st.floats(0.5, 8.0))
def test_motion_is_no_jump(speed):
    assert not np.any(jumps(angle(speed)))


def test_an_axis_that_starts_and_stops_at_once_does_not_jump():
    time = np.arange(400)
    position = 1e-3 * np.clip(np.abs((time % 100) - 50) - 10, 0, 30)
    assert not np.any(jumps(position))


def test_lost_counts_are_a_jump_that_is_left_where_it_is():
    lost = angle(2.0)
    lost[900:] += 0.5
    (row,) = np.flatnonzero(jumps(lost))
    assert row == 899
    assert continued(lost, rotary=True).wraps == 0
