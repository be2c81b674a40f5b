"""A file is the old one or the new one, whatever happens in between."""

import os
import signal
import stat
import subprocess
import sys

import hypothesis
import hypothesis.strategies as st
import pytest

from scdpr_jax.numerics.files import whole_file, write_whole


# A lone surrogate has no UTF-8, and is written out.
def test_a_lone_surrogate_is_written_as_json_writes_it(tmp_path):
    write_whole(tmp_path / "a.json", '"\udcff"')
    assert (tmp_path / "a.json").read_text() == r'"\udcff"'


@hypothesis.given(st.text(st.characters(exclude_categories=["Cs"])))
def test_a_text_is_read_as_it_was_written(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("out") / "text.csv"
    write_whole(path, text)
    assert path.read_bytes().decode() == text


def test_a_folder_that_is_missing_is_made(tmp_path):
    write_whole(tmp_path / "a" / "b" / "text.csv", "1")
    assert (tmp_path / "a" / "b" / "text.csv").read_text() == "1"


def test_a_writer_that_fails_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / "text.csv"
    write_whole(path, "old")

    def half():
        with whole_file(path) as scratch:
            scratch.write_text("ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert [(one.name, one.read_text()) for one in tmp_path.iterdir()] == [("text.csv", "old")]


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_result_is_readable_to_whom_the_users_mask_lets(tmp_path, mask):
    before = os.umask(mask)
    try:
        for _ in range(2):  # new, and in another's place
            write_whole(tmp_path / "text.csv", "1")
            assert stat.S_IMODE((tmp_path / "text.csv").stat().st_mode) == 0o666 & ~mask
    finally:
        os.umask(before)


KILLED = """
import os, pathlib, signal
from scdpr_jax.numerics.files import whole_file
with whole_file(pathlib.Path({path!r})) as scratch:
    scratch.write_text("ne")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="no files without a name here")
def test_a_process_that_is_killed_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / "text.csv"
    write_whole(path, "old")
    killed = subprocess.run([sys.executable, "-c", KILLED.format(path=str(path))], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert [(one.name, one.read_text()) for one in tmp_path.iterdir()] == [("text.csv", "old")]


@pytest.mark.parametrize("nameless", [True, False])
def test_a_file_takes_anothers_place_on_disks_without_nameless_files_as_well(
    tmp_path, nameless, monkeypatch
):
    if not nameless:
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)
    path = tmp_path / "text.csv"
    for text in ("old", "new"):
        write_whole(path, text)
        assert [(one.name, one.read_text()) for one in tmp_path.iterdir()] == [
            (path.name, text)
        ]


def test_a_writer_that_needs_a_name_has_one_and_nothing_of_it_stays(tmp_path):
    (tmp_path / "in").mkdir()
    for text in ("old", "new"):
        with whole_file(tmp_path / "film.mp4", named_in=tmp_path / "in") as scratch:
            assert scratch.parent == tmp_path / "in"
            scratch.write_text(text)
        assert (tmp_path / "film.mp4").read_text() == text
        assert not any((tmp_path / "in").iterdir())
