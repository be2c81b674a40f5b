"""Laws of a progress bar's clock."""

import json
import math

import hypothesis
from hypothesis import strategies as st

from experiments.page.pace import EVEN, USUAL, Clock, Detour, Pace, expected, keep

SHARE = st.floats(0.0, 1.0)
TELLINGS = st.lists(st.tuples(st.floats(0.01, 20.0), SHARE), min_size=1, max_size=20)
KNOWN = Pace(10.0, ((0.2, 0.5), (0.6, 0.7)))
LATER = Pace(20.0, ((0.3, 0.25), (0.45, 0.5)), belief=0.02, origin=0.2)
"""How it goes on where there is more to do: 5 s to 0.3, 10 s to 0.45."""
WHOLE = Pace(20.0, ((0.2, 0.25), (0.3, 0.5), (0.45, 0.75)), belief=0.02)
BRANCHING = KNOWN.with_detour(Detour(0.2, 0.6, LATER))


@hypothesis.given(tellings=TELLINGS, pace=st.sampled_from((KNOWN, EVEN, BRANCHING)))
def test_a_bar_never_goes_back_nor_past_its_end(tellings, pace):
    clock, now, last = Clock(pace, 0.0), 0.0, 0.0
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
    usual = USUAL["tune"]
    assert expected("tune", file) == usual.first
    keep("tune", Pace(3 * usual.first.total, ((0.5, 0.9),)), file)
    second = expected("tune", file)
    assert (second.total, second.points) == (3 * usual.again.total, usual.again.points)


def test_what_a_calibration_has_compiled_is_compiled_for_its_stages(tmp_path):
    file = tmp_path / "paces.json"
    keep("calibrate", KNOWN, file)
    assert expected("identify", file).points == USUAL["identify"].again.points


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


def test_a_detour_has_a_time_of_its_own_however_long_it_took_to_get_there():
    for before in (1.0, 5.0, 50.0):
        clock = Clock(BRANCHING, 0.0)
        clock.tell(0.2, before)
        clock.tell(0.25, before)
        clock.tell(0.3, before + 5.0)
        for now in (5.0, 10.0, 14.0):
            if now == 10.0:
                clock.tell(0.45, before + now)
            assert math.isclose(clock.standing(before + now).left, 20 - now, rel_tol=0.05)


def test_a_detour_that_is_known_as_a_whole_is_told_by_all_that_has_passed():
    clock = Clock(KNOWN.with_detour(Detour(0.2, 0.6, WHOLE)), 0.0)
    for share, now in ((0.2, 10.0), (0.25, 12.0), (0.3, 20.0)):  # half as fast as expected
        clock.tell(share, now)
    assert math.isclose(clock.standing(20.0).left, 20.0, rel_tol=0.05)


def test_what_goes_past_a_detour_is_told_without_it():
    clock = Clock(BRANCHING, 0.0)
    for share, now in ((0.2, 5.0), (0.6, 7.0)):
        clock.tell(share, now)
        assert math.isclose(clock.standing(now).left, 10 - now, rel_tol=1e-9)


def test_a_comparison_of_models_is_told_by_what_has_been_compiled(tmp_path):
    file, usual = tmp_path / "paces.json", USUAL["identify"]
    assert expected("identify", file).detour == usual.first_detour
    keep("identify", Pace(30.0, ((0.2, 0.3), (0.5, 0.7))), file)
    assert expected("identify", file).detour == usual.detour
    keep("identify", Pace(9.0, ((0.2, 0.3), (0.5, 0.7))), file, given="rig")
    assert expected("identify", file, given="rig").detour is None


def test_a_telling_just_short_of_an_expected_one_counts_as_it():
    clock = Clock(Pace(100.0, ((0.5, 0.4), (0.7, 0.8))), 0.0)
    clock.tell(0.4999, 40.0)
    assert clock.standing(60.0).share > 0.55
