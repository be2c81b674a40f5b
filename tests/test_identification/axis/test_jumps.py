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
    got = continued(TIME, wrapped, rotary=True)
    np.testing.assert_allclose(got.position - got.position[0], whole - whole[0], atol=1e-9)
    assert got.wraps == np.count_nonzero(np.abs(np.diff(wrapped)) > math.pi)


@pytest.mark.parametrize("bits", [15, 16])
def test_counters_wrap_at_their_bits(bits):
    step = 1e-5
    counts = np.round((0.2 * np.sin(TIME) + 0.1 * TIME) / step)
    got = continued(TIME, step * np.mod(counts, 2**bits), rotary=False)
    # A quarter of the log has a wrap at least.
    assert got.wraps >= 1
    assert got.period == pytest.approx(2**bits * step)
    np.testing.assert_allclose(np.diff(got.position), np.diff(step * counts), atol=1e-9)


@given(speed=st.floats(0.5, 8.0))
def test_motion_is_no_jump(speed):
    assert not np.any(jumps(TIME, angle(speed)))


def test_an_axis_that_starts_and_stops_at_once_does_not_jump():
    time = np.arange(400.0)
    position = 1e-3 * np.clip(np.abs((time % 100) - 50) - 10, 0, 30)
    assert not np.any(jumps(time, position))


def test_lost_counts_are_a_jump_that_is_left_where_it_is():
    lost = angle(2.0)
    lost[900:] += 0.5
    (row,) = np.flatnonzero(jumps(TIME, lost))
    assert row == 899
    assert continued(TIME, lost, rotary=True).wraps == 0


@pytest.mark.parametrize("missing", [2, 40, 400])
def test_where_samples_are_missing_motion_is_no_jump_and_wraps_are_none(missing):
    kept = np.ones(len(TIME), dtype=bool)
    kept[700 : 700 + missing] = False
    time, moved = TIME[kept], angle(6.0)[kept]
    # Counts of a size at which the gap is as long as a counter's range.
    gap = abs(moved[700] - moved[699])
    counts = np.round(moved / gap * 2**15) * gap / 2**15
    assert continued(time, counts, rotary=False).wraps == 0
    assert not np.any(jumps(time, counts))


def test_an_angle_that_wraps_goes_on_where_samples_are_missing():
    kept = np.ones(len(TIME), dtype=bool)
    kept[::7] = False
    whole = angle(6.0)[kept]
    got = continued(TIME[kept], np.mod(whole, 2 * math.pi), rotary=True)
    np.testing.assert_allclose(got.position - got.position[0], whole - whole[0], atol=1e-9)
