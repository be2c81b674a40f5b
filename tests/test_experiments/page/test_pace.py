"""Laws of a progress bar's clock."""

import json
import math

import hypothesis
from hypothesis import strategies as st

from experiments.page.pace import EVEN, USUAL, Clock, Pace, expected, keep

SHARE = st.floats(0.0, 1.0)
TELLINGS = st.lists(st.tuples(st.floats(0.01, 20.0), SHARE), min_size=1, max_size=20)
KNOWN = Pace(10.0, ((0.2, 0.5), (0.6, 0.7)))


@hypothesis.given(tellings=TELLINGS, known=st.booleans())
def test_a_bar_never_goes_back_nor_past_its_end(tellings, known):
    clock, now, last = Clock(KNOWN if known else EVEN, 0.0), 0.0, 0.0
    for step, share in tellings:
        for part in (0.3, 1.0):
            at = clock.standing(now + part * step).share
            assert last <= at <= 1.0
            last = at
        now += step
        clock.tell(share, now)


@hypothesis.given(st.floats(0.1, 30.0))
def test_a_bar_goes_on_while_nothing_is_told(seconds):
    clock = Clock(KNOWN, 0.0)
    assert clock.standing(seconds).share < clock.standing(seconds + 2).share < 0.5


def test_what_goes_as_the_last_time_is_told_with_the_time_that_is_left():
    clock = Clock(KNOWN, 0.0)
    for now, share in ((5.0, 0.2), (7.0, 0.6)):
        assert math.isclose(clock.standing(now).left, 10 - now, rel_tol=0.5)
        clock.tell(share, now)
        assert math.isclose(clock.standing(now).left, 10 - now, rel_tol=1e-9)


def test_on_a_machine_that_is_twice_as_slow_the_second_half_is_told_within_half():
    clock = Clock(KNOWN, 0.0)
    clock.tell(0.2, 10.0)
    for now in range(10, 19):
        if now == 14:
            clock.tell(0.6, 14.0)
        left = clock.standing(float(now)).left
        assert (20 - now) / 1.5 <= left <= 1.5 * (20 - now)


def test_a_pace_is_what_it_was():
    clock = Clock(EVEN, 3.0)
    for share, now in ((0.2, 8.0), (0.1, 9.0), (0.6, 10.0)):
        clock.tell(share, now)
    kept = clock.pace(13.0)
    assert kept == Pace(10.0, ((0.2, 0.5), (0.6, 0.7)))


def test_the_first_time_is_no_measure_for_the_second(tmp_path):
    file = tmp_path / "paces.json"
    (first, again) = USUAL["tune"]
    assert expected("tune", file) == first
    keep("tune", Pace(3 * first.total, ((0.5, 0.9),)), file)
    second = expected("tune", file)
    assert (second.total, second.points) == (3 * again.total, again.points)


def test_what_a_calibration_has_compiled_is_compiled_for_its_stages(tmp_path):
    file = tmp_path / "paces.json"
    keep("calibrate", KNOWN, file)
    assert expected("identify", file) == USUAL["identify"][1]


def test_the_same_input_counts_more_than_the_last_one(tmp_path):
    file = tmp_path / "paces.json"
    for given, total in (("long", 40.0), ("short", 4.0), ("long", 40.0), ("short", 4.0)):
        keep("sweep", Pace(total, ()), file, given=given)
    assert expected("sweep", file, given="long").total == 40.0
    assert expected("sweep", file, given="new").total == 4.0


def test_a_moment_is_the_mean_of_the_calls_before():
    last, pace = Pace(10.0, ((0.5, 0.4),)), Pace(30.0, ((0.5, 0.6),))
    assert pace.after(last) == Pace(30.0, ((0.5, 0.5),))


def test_a_call_that_waits_from_its_middle_on_is_told_within_half_of_what_is_left():
    even = Pace(10.0, tuple((n / 20, n / 20) for n in range(1, 20)))
    clock = Clock(even, 0.0)
    for n in range(1, 20):  # 5 s for the first half, 7.5 s for the second
        now = n / 2 if n <= 10 else 5.0 + 0.75 * (n - 10)
        clock.tell(n / 20, now)
        left = clock.standing(now).left
        if n >= 12:
            assert (12.5 - now) / 1.5 <= left <= 1.5 * (12.5 - now)


def test_what_passes_before_the_first_stage_has_its_time_as_well():
    first = Clock(EVEN, 0.0)
    for share, now in ((0.0, 4.0), (0.5, 6.0)):
        first.tell(share, now)
    again = Clock(first.pace(10.0), 0.0)
    again.tell(0.0, 4.0)
    assert math.isclose(again.standing(4.0).share, 0.4)


def test_only_the_last_paces_are_kept(tmp_path):
    file = tmp_path / "paces.json"
    for n in range(60):
        keep("sweep", Pace(n + 1.0, ()), file, given=str(n))
    assert expected("sweep", file, given="59").total == 60.0
    assert expected("sweep", file, given="0").total == 60.0  # as the last one
    assert len(json.loads(file.read_text())) <= 50


def test_a_spoilt_file_of_paces_is_as_none(tmp_path):
    file = tmp_path / "paces.json"
    for text in ("", "{", "[]", '{"sweep": 3}', '{"sweep": ["x", []]}', '{"sweep": [0, []]}'):
        file.write_text(text)
        assert expected("sweep", file) == EVEN
    keep("sweep", KNOWN, file)
    assert expected("sweep", file).total == KNOWN.total
