import dataclasses
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from identification.vision.settings.document import Time
from identification.vision.timing.clock import doubled, dropped, read_clock
from identification.vision.timing.shutter import (
    at_frame_times,
    interpolation_error,
    lagrange,
)
from identification.vision.timing.tripod import mean_marks, shake_of

FRAMES = 0.05 + np.arange(20) / 30
number = st.floats(-2, 2)


def clock(height=1001, **changes):
    time = {"frame_rate": "30 Hz", "first_frame": "0.05 s", "readout": "20 ms", **changes}
    return read_clock(Time(**time), Path(), count=len(FRAMES), height=height)


@hypothesis.given(coefficients=st.lists(number, min_size=5, max_size=5))
def test_motion_of_the_fourth_order_is_put_at_the_pictures_time_exactly(coefficients):
    late = FRAMES + 8e-3
    values = np.polynomial.polynomial.polyval(late, coefficients)
    wanted = np.polynomial.polynomial.polyval(FRAMES, coefficients)
    found = at_frame_times(np.stack([values, -values], axis=-1), late, FRAMES)
    # 1e-12: some roundings of numbers up to 20.
    np.testing.assert_allclose(found[2:-2, 0], wanted[2:-2], atol=1e-12)


def test_vibration_of_five_hertz_is_followed_to_a_hundredth_of_what_the_rows_cost():
    def place(t):
        return 6e-3 * np.sin(2 * np.pi * 5 * t)

    late = FRAMES + 8e-3
    found = at_frame_times(np.stack([place(late)] * 2, axis=-1), late, FRAMES)[:, 0]
    cost = np.abs(place(late) - place(FRAMES)).max()
    assert np.abs(found - place(FRAMES))[2:-2].max() < 0.05 * cost


def test_a_sample_without_two_neighbours_has_no_value_at_another_time():
    values = np.full((20, 2), np.nan)
    values[[3, 4, 14]] = 1.0
    assert np.isnan(at_frame_times(values, FRAMES + 5e-3, FRAMES)).all()


def test_what_the_neighbours_disagree_about_is_told():
    values = np.zeros((20, 2))
    values[11:] = 5.0
    error = interpolation_error(values, FRAMES + 8e-3, FRAMES)
    assert np.abs(error[10]).min() > 0.1
    assert not error[4].any()


@hypothesis.given(
    own=st.lists(st.booleans(), min_size=20, max_size=20),
    seen=st.lists(st.booleans(), min_size=20, max_size=20),
)
def test_a_value_and_how_far_it_may_be_off_are_known_of_the_same_pictures(own, seen):
    """Some rows are exposed at their picture's time, some pictures miss the marker."""
    late = FRAMES + np.where(own, 0.0, 8e-3)
    values = np.where(np.array(seen)[:, None], np.sin([40 * late, 30 * late]).T, np.nan)
    found, error = (f(values, late, FRAMES) for f in (at_frame_times, interpolation_error))
    np.testing.assert_array_equal(np.isnan(found), np.isnan(error))
    there = np.array(own) & seen
    np.testing.assert_array_equal(found[there], values[there])
    assert (error[there] == 0).all()


def test_a_picture_alone_has_a_value_only_at_its_own_time():
    for late, known in ((0.0, True), (8e-3, False)):
        found = at_frame_times(np.ones((1, 2)), np.array([1.0 + late]), np.array([1.0]))
        assert np.isfinite(found).all() == known


def test_weights_of_a_polynomial_add_up_to_one():
    assert lagrange(np.array([0.0, 1.0, 2.5]), 0.7).sum() == pytest.approx(1)


def test_rows_are_exposed_around_the_middle_one_in_the_direction_that_is_stated():
    down, up = clock(), clock(readout_direction="up")
    assert down.offset(np.array([0.0, 500.0, 1000.0])) == pytest.approx([-0.01, 0, 0.01])
    assert up.offset(np.array([0.0, 1000.0])) == pytest.approx([0.01, -0.01])


def test_a_stamp_of_the_first_row_is_half_of_exposure_and_readout_early():
    late = clock(exposure="4 ms", stamp_at="first row, start of exposure")
    np.testing.assert_allclose(late.frames, FRAMES + 12e-3)


def test_stamps_are_taken_from_their_file_and_pictures_without_one_have_no_time(tmp_path):
    (tmp_path / "frames.csv").write_text("frame,t [ms]\n0,50\n1,83\n3,150\n")
    time = Time(stamps="frames.csv")
    found = read_clock(time, tmp_path, count=4, height=10).frames
    np.testing.assert_allclose(found, [0.05, 0.083, np.nan, 0.15])
    assert dropped(np.array([0.0, 1.0, 2.0, 5.0, 6.0])) == 2


@pytest.mark.parametrize(
    ("text", "word"),
    [("number,time\n1,2\n", "`frame` and `t"), ("frame,t [s]\n0,x\n", "row 2"), ("", "none")],
)
def test_stamps_that_cannot_be_read_are_refused(tmp_path, text, word):
    (tmp_path / "frames.csv").write_text(text)
    with pytest.raises(ValueError, match=r"frames\.csv") as caught:
        read_clock(Time(stamps="frames.csv"), tmp_path, count=4, height=10)
    assert word in str(caught.value)


def moving(count=40):
    return np.stack([np.arange(count) * 5.0, np.zeros(count)], axis=-1)[:, None]


def test_a_copied_picture_is_told_among_still_and_moving_ones():
    change = np.array([np.inf] + [2.7, 2.6, 2.9, 2.8] * 5 + [40.0, 55.0] * 9 + [38.0])
    change[[7, 30]] = 0.0, 0.3
    found = doubled(change, np.zeros((len(change), 1, 2)))
    assert np.flatnonzero(found).tolist() == [7, 30]


def test_still_pictures_are_no_copies():
    change = np.array([np.inf] + [2.2, 2.5, 2.4, 2.3] * 3 + [14.0, 45.0, 60.0] * 9)
    assert not doubled(change, np.zeros((len(change), 1, 2))).any()


def test_a_copy_that_a_codec_has_changed_is_told_by_what_has_not_moved():
    pixels = moving()
    pixels[20] = pixels[19]
    change = np.full(40, 45.0)
    change[20] = 3.1
    change[:4] = 2.5
    assert np.flatnonzero(doubled(change, pixels)).tolist() == [20]


def test_a_coded_copy_is_told_at_rest_where_a_lamp_flickers():
    change = np.full(40, 55.0) + np.arange(40) % 7
    change[[9, 25]] = 0.6, 3.1
    found = doubled(change, np.zeros((40, 1, 2)))
    assert np.flatnonzero(found).tolist() == [9, 25]


def test_copies_in_a_row_are_told_and_a_robot_that_rests_is_none():
    pixels = moving()
    pixels[20:22] = pixels[19]
    change = np.full(40, 80.0)
    change[20:22] = 1.8, 1.9
    assert np.flatnonzero(doubled(change, pixels)).tolist() == [20, 21]
    pixels[20:32] = pixels[19]
    change[20:32] = 1.9
    assert not doubled(change, pixels).any()


def test_a_steady_camera_is_left_alone_and_a_shaking_one_is_followed():
    random = np.random.default_rng(3)
    marks = random.uniform(0, 1000, (5, 2))
    noise = random.normal(0, 0.02, (20, 5, 2))
    still = marks + noise
    every = np.ones(20, bool)
    assert not shake_of(still, clock(), every).filled.any()
    wave = np.stack([np.sin(2 * np.pi * 2 * FRAMES), np.cos(2 * np.pi * 3 * FRAMES)], axis=-1)
    shake = shake_of(still + wave[:, None], clock(readout="0 s"), every).filled
    apart = shake - wave
    # Five marks' noise of 0.02 px, and a constant that is the marks' own place.
    assert (apart - apart.mean(axis=0)).std() < 0.02
    assert np.isfinite(mean_marks(still - shake[:, None])).all()


NOISE, FRAME_COUNT = 0.02, 60  # px; pictures of a shaken film


def shaken(seed, *, rates, rows):
    """Marks and markers before a camera that shakes, pictures missing.

    Returns what is told of the shift, its errors at the markers' rows, and these rows' times.
    """
    random = np.random.default_rng(seed)
    kept = np.sort(random.choice(FRAME_COUNT + 4, FRAME_COUNT, replace=False))
    stamps = kept / 30
    told = dataclasses.replace(clock(), frames=stamps)
    phases = random.uniform(0, 2 * np.pi, (2, len(rates)))

    def sway(t):
        waves = np.sin(2 * np.pi * np.array(rates) * t[..., None, None] + phases)
        return (waves * [0.9, 0.7, 0.4][: len(rates)]).sum(axis=-1)

    def rounds(places):
        seen = np.broadcast_to(places, (FRAME_COUNT, *places.shape))
        for _ in range(4):
            shift = sway(stamps[:, None] + told.offset(seen[..., 1]))
            seen = places + shift
        return seen, shift

    marks = np.stack([random.uniform(0, 1000, len(rows)), rows], axis=-1)
    seen, _ = rounds(marks)
    usable = np.ones(FRAME_COUNT, bool)
    usable[random.choice(np.arange(3, FRAME_COUNT - 3), 3, replace=False)] = False
    found = shake_of(seen + NOISE * random.normal(size=seen.shape), told, usable)
    markers, true = rounds(np.array([[300.0, 150.0], [500.0, 480.0], [700.0, 850.0]]))
    after = told.offset(markers[..., 1])
    off = np.stack([found.at(stamps, stamps + each) for each in after.T], axis=1) - true
    off = (off - np.median(off, axis=0))[usable]
    return found, np.sqrt((off**2).mean(axis=0)).T, np.where(usable[:, None], after, np.nan)


ROWS = {
    "corners": [40.0, 40.0, 960.0, 960.0],
    "corners and sides": [40.0, 40.0, 960.0, 960.0, 500.0, 450.0],
    "anywhere": [100.0, 230.0, 380.0, 610.0, 720.0, 800.0, 930.0],
}


SLOW, FAST = (1.3,), (1.7, 4.1, 7.3)  # Hz


# Marks in the corners alone don't tell what a fast shake does to the row in their middle.
@pytest.mark.parametrize(
    ("rows", "rates"),
    [
        ("corners", SLOW),
        ("corners and sides", SLOW),
        ("corners and sides", FAST),
        ("anywhere", SLOW),
        ("anywhere", FAST),
    ],
)
def test_what_a_shift_is_off_by_at_a_markers_row_is_stated(rows, rates):
    shots = [shaken(seed, rates=rates, rows=ROWS[rows]) for seed in range(6)]
    ratios = np.array([found.error(after) / true for found, true, after in shots])
    typical = np.exp(np.log(ratios).mean(axis=0))
    assert np.all((typical > 0.8) & (typical < 1.25)), typical
    # Some 57 numbers tell a deviation to a tenth.
    assert np.mean((ratios > 0.7) & (ratios < 1.5)) > 0.95, ratios


def test_rows_far_from_the_middle_one_are_no_worse_than_the_marks_noise():
    """Pictures before and after would leave 0.05 px and more of a shake of 7 Hz."""
    for seed in range(4):
        _, true, _ = shaken(seed, rates=FAST, rows=ROWS["corners and sides"])
        assert true.max() < NOISE, true


def test_a_mark_that_is_seen_once_is_put_right_by_its_own_row():
    told = clock()
    marks = np.array([[100.0, 50.0], [900.0, 50.0], [100.0, 950.0], [900.0, 950.0]])
    late = FRAMES[:, None] + told.offset(marks[:, 1])
    seen = marks + np.stack([np.sin(2 * np.pi * 3.0 * late), 0 * late], axis=-1)
    once = seen.copy()
    once[np.arange(20) != 7, 3] = np.nan
    found = shake_of(once, told, np.ones(20, bool))
    off = mean_marks(found.without(once, told)) - marks
    apart = off - off[0]
    # 0.02 px: interpolation at the ends of the film moves means by as much.
    assert np.abs(apart).max() < 0.02, apart


def test_a_steady_cameras_shift_is_off_by_nothing():
    marks = np.random.default_rng(3).uniform(50, 700, (6, 2))
    noise = 0.02 * np.random.default_rng(4).normal(size=(20, 6, 2))
    found = shake_of(marks + noise, clock(), np.ones(20, bool))
    assert not found.error(np.full((20, 4), 8e-3)).any()
