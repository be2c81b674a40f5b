"""A file is the old one or the new one, whatever happens in between."""

import stat

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


def test_anybody_may_read_the_result(tmp_path):
    write_whole(tmp_path / "text.csv", "1")
    assert stat.S_IMODE((tmp_path / "text.csv").stat().st_mode) == 0o644
