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
    assert expected("tune", file) == again.scaled(3 * again.total)
    keep("tune", KNOWN, file)
    assert expected("tune", file) == KNOWN


def test_a_spoilt_file_of_paces_is_as_none(tmp_path):
    file = tmp_path / "paces.json"
    for text in ("", "{", "[]", '{"tune": 3}', json.dumps({"tune": {"total": "x"}})):
        file.write_text(text)
        assert expected("sweep", file) == EVEN
    keep("sweep", KNOWN, file)
    assert expected("sweep", file) == KNOWN


WORKED = Pace(10.0, ((0.2, 0.5), (0.6, 0.7)), (5.0, 7.0, 10.0))


def test_where_others_take_the_processor_a_part_goes_by_what_it_has_worked():
    # As much work as the last time, in three times the time.
    clock = Clock(WORKED, 0.0, 100.0)
    told = {15: 0.2, 21: 0.6}
    for now in range(1, 30):
        used = 100.0 + now / 3
        if now in told:
            clock.tell(told[now], float(now), used)
        standing = clock.standing(float(now), used)
        if now >= 15:
            assert (30 - now) / 1.5 <= standing.left <= 1.5 * (30 - now)
        if now <= 24:  # then it slows down, as it might take longer
            assert math.isclose(standing.share, now / 30, abs_tol=0.02)


def test_what_others_have_worked_goes_by_the_clock():
    waits = Pace(10.0, ((0.5, 0.5),), (0.1, 0.2))
    clock = Clock(waits, 0.0)
    assert math.isclose(clock.standing(2.0, 0.01).share, 0.2)


def test_processor_time_is_kept(tmp_path):
    file = tmp_path / "paces.json"
    clock = Clock(EVEN, 0.0, 2.0)
    clock.tell(0.5, 4.0, 5.0)
    keep("sweep", clock.pace(8.0, 9.0), file)
    assert expected("sweep", file) == Pace(8.0, ((0.5, 0.5),), (3.0, 7.0))


def test_what_slows_down_in_the_middle_is_told_sooner_than_by_the_mean():
    # Half as fast from the middle on: 5 s for the first half, 10 s for the second.
    even = Pace(
        10.0, tuple((n / 20, n / 20) for n in range(1, 20)), tuple(map(float, range(20)))
    )
    clock = Clock(even, 0.0)
    for n in range(1, 20):
        now = n / 2 if n <= 10 else 5.0 + (n - 10)
        clock.tell(n / 20, now, float(n - 1))
        left = clock.standing(now, float(n - 1)).left
        if 14 <= n <= 18:
            assert (15 - now) / 1.5 <= left <= 15 - now
