"""Parts of a computation tell their own share; the listener hears the whole's."""

import hypothesis
import hypothesis.strategies as st

from scdpr_jax.numerics import progress as module
from scdpr_jax.numerics.progress import SILENT, Progress

share = st.floats(0.0, 1.0)


def listening():
    told = []
    return Progress(lambda doing, share: told.append((doing, share))), told


def test_a_part_ends_where_the_next_begins():
    progress, told = listening()
    progress.part(0.2, 0.6)("fit", 1.0)
    progress.part(0.6, 1.0)("judged", 0.0)
    assert told == [("fit", 0.6), ("judged", 0.6)]


@hypothesis.given(share, share, share)
def test_a_part_of_a_part_stays_within_both(first, second, done):
    progress, told = listening()
    begin, end = sorted((first, second))
    progress.part(0.25, 0.75).part(begin, end)("fit", done)
    ((_, at),) = told
    # A rounding of each of the two.
    slack = 4e-16
    assert 0.25 + 0.5 * begin - slack <= at <= 0.25 + 0.5 * end + slack


def test_more_than_all_counts_as_all():
    progress, told = listening()
    progress.part(0.0, 0.5)("fit", 3.0)
    assert told == [("fit", 0.5)]


def test_names_of_parts_stand_before_what_they_say():
    progress, told = listening()
    progress.part(0.0, 1.0, "2.3 s").part(0.0, 1.0, "all models")("", 0.0)
    progress.part(0.0, 1.0, "2.3 s")("starts", 0.0)
    assert [doing for doing, _ in told] == ["2.3 s: all models", "2.3 s: starts"]


def test_nobody_hears_a_silent_one():
    assert SILENT.part(0.0, 0.5, "fit")("start", 1.0) is None


def test_true_is_a_line_in_a_notebook_that_never_falls(capsys):
    told = module.listening(True)
    for share in (0.5, 0.2, 1.0):
        told("fit", share)
    lines = capsys.readouterr().err.split("\r")[1:]
    assert [line.split()[0] for line in lines] == ["50", "50", "100"]
    assert all("fit" in line for line in lines)


def test_false_is_silence_and_a_listener_stays_one(capsys):
    told, heard = listening()
    assert module.listening(told) is told
    module.listening(False)("fit", 0.5)
    assert module.listening(False) is SILENT
    assert not heard
    assert capsys.readouterr().err == ""
