"""The exports' folder, and what can't be exported."""

import dataclasses

import hypothesis
import pytest
from hypothesis import strategies as st
from tunings import plain

from tuning.export import write_exports
from tuning.export.description import decimal
from tuning.export.labview import CAUTION_COLUMN
from tuning.export.write import FORMATS
from tuning.result.document import read_tuning, write_tuning
from tuning.result.tuning import CAUTION


@pytest.fixture(autouse=True)
def on_board(monkeypatch):
    """Texts in place of a planner's, which takes its time and has tests of its own."""
    texts = {"README.md": "how", "scdpr_leg.c": "what"}
    monkeypatch.setattr("tuning.export.write.onboard_files", lambda _: texts)


def test_the_folder_holds_the_files_that_are_named_and_no_other(tmp_path):
    written = write_exports(tmp_path / "export", plain())
    folder = tmp_path / "export"
    every = (path for path in folder.rglob("*") if path.is_file())
    assert {str(path.relative_to(folder)) for path in every} == {
        "scdpr_controller.h",
        "controller.csv",
        "shapers.csv",
        "scdpr_controller.m",
        "provenance.json",
        "onboard/README.md",
        "onboard/scdpr_leg.c",
    }
    assert {path for path in folder.rglob("*") if path.is_file()} == {*written}


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


MARKS = {
    "scdpr_controller.h": (CAUTION, "#define SCDPR_MODEL_DOES_NOT_FIT 1"),
    "scdpr_controller.m": (f"% {CAUTION}",),
    "controller.csv": (f",{CAUTION_COLUMN}\n",),
    "shapers.csv": (f",{CAUTION_COLUMN}\n",),
}
"""What each file is marked by where the fit has failed."""


def test_every_format_has_a_mark():
    assert {name for name, _ in FORMATS} == set(MARKS)


@pytest.mark.parametrize("name", MARKS)
def test_a_file_is_marked_only_if_the_fit_has_failed(name, tmp_path):
    good, failed = tmp_path / "good", tmp_path / "failed"
    write_exports(good, plain())
    write_exports(failed, dataclasses.replace(plain(), caution=CAUTION))
    for mark in MARKS[name]:
        assert mark in (failed / name).read_text()
        assert mark not in (good / name).read_text()


@pytest.mark.parametrize("name", ["controller.csv", "shapers.csv"])
def test_the_mark_is_a_last_column_that_moves_no_other(name, tmp_path):
    write_exports(tmp_path / "good", plain())
    write_exports(tmp_path / "failed", dataclasses.replace(plain(), caution=CAUTION))
    good, failed = (
        (tmp_path / kind / name).read_text().splitlines() for kind in ("good", "failed")
    )
    assert [line.rsplit(",", 1)[0] for line in failed] == good
    assert {line.rsplit(",", 1)[1] for line in failed[1:]} == {"1"}
