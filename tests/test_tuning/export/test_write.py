"""The exports' folder, and what can't be exported."""

import dataclasses

import hypothesis
import pytest
from hypothesis import strategies as st
from tunings import plain

from tuning.export import write_exports
from tuning.export.description import decimal
from tuning.result.document import read_tuning, write_tuning


def test_the_folder_holds_the_files_that_are_named_and_no_other(tmp_path):
    written = write_exports(tmp_path / "export", plain())
    assert sorted(written) == sorted((tmp_path / "export").iterdir())
    assert {path.name for path in written} == {
        "scdpr_controller.h",
        "controller.csv",
        "shapers.csv",
        "scdpr_controller.m",
    }


def test_a_tuning_that_was_read_exports_the_same_files(tmp_path):
    write_tuning(tmp_path / "tuning.json", plain())
    again = read_tuning(tmp_path / "tuning.json")
    pairs = zip(
        write_exports(tmp_path / "a", plain()),
        write_exports(tmp_path / "b", again),
        strict=True,
    )
    assert all(first.read_text() == second.read_text() for first, second in pairs)


@pytest.mark.parametrize(
    ("missing", "told"), [("robots", "no fitted robot"), ("shapers", "no shaper")]
)
def test_what_can_not_be_exported_is_refused_and_nothing_written(missing, told, tmp_path):
    with pytest.raises(ValueError, match=told):
        write_exports(tmp_path / "export", dataclasses.replace(plain(), **{missing: ()}))
    assert not (tmp_path / "export").exists()


@hypothesis.given(number=st.floats(allow_nan=False, allow_infinity=False))
def test_a_decimal_reads_back_to_the_same_bits_without_an_exponent(number):
    text = decimal(number)
    assert float(text) == number
    assert "e" not in text
    assert "." in text
