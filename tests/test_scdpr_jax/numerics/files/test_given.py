"""A file is looked at before it is opened."""

import os
import pathlib
import sys

import pytest

from scdpr_jax.numerics.files.given import (
    CELL,
    FileError,
    read_given,
    read_given_rows,
    read_given_text,
)


@pytest.mark.parametrize("size", [0, 1, 9, 10])
def test_a_file_within_the_limit_is_read_whole(size, tmp_path):
    (tmp_path / "a").write_bytes(bytes(size))
    assert read_given(tmp_path / "a", most=10) == bytes(size)


def test_a_larger_one_is_refused_with_the_limit(tmp_path):
    (tmp_path / "a").write_bytes(bytes(2**20 + 1))
    with pytest.raises(
        FileError, match=r"a: the file is too large, got 1\.0 MiB or more"
    ) as own:
        read_given(tmp_path / "a", most=2**20)
    assert own.value.expected == "1 MiB at most"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipes among files")
def test_a_pipe_is_refused_without_waiting_for_its_writer(tmp_path):
    os.mkfifo(tmp_path / "a")
    with pytest.raises(FileError, match="got a pipe"):
        read_given(tmp_path / "a", most=10)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no devices among files")
def test_a_device_is_refused():
    with pytest.raises(FileError, match="got a device"):
        read_given(pathlib.Path("/dev/zero"), most=10)


def test_a_file_that_is_not_there_is_the_systems_own_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_given(tmp_path / "a", most=10)


def test_what_is_no_text_is_told_with_its_row(tmp_path):
    (tmp_path / "a").write_bytes(b"1\n2\n\xff")
    with pytest.raises(FileError, match="the byte 0xff in row 3"):
        read_given_text(tmp_path / "a", most=10)


def test_rows_know_their_lines_and_empty_ones_are_none(tmp_path):
    (tmp_path / "a").write_text('\ufeffa,"b\nc"\n\n1,2\n', encoding="utf-8")
    assert read_given_rows(tmp_path / "a") == [(2, ["a", "b\nc"]), (4, ["1", "2"])]


@pytest.mark.parametrize("length", [CELL + 1, 200_000])
def test_a_cell_that_nobody_writes_is_told_with_its_row(length, tmp_path):
    (tmp_path / "a").write_text("a,b\n1," + "9" * length)
    with pytest.raises(FileError, match="row 2 can't be split"):
        read_given_rows(tmp_path / "a")
