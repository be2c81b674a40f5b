"""Logs in text are read a piece at a time: where a piece ends makes no difference."""

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from identification.bring.files.csv import log as csv_log
from identification.bring.files.csv import text as csv_text
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.csv.text import Text
from identification.bring.streams import stamps

ENDS = ("\n", "\r\n", "\r", "\n\n", "\x0b", "\x85", "\u2028", "")


@hypothesis.given(
    parts=st.lists(st.tuples(st.text("aé€\U0001f600;1", max_size=5), st.sampled_from(ENDS))),
    encoding=st.sampled_from(["utf-8", "utf-16", "utf-16-le", "utf-8-sig"]),
    piece=st.integers(1, 9),
)
def test_lines_are_those_of_the_whole_text(parts, encoding, piece):
    whole = "".join(text + end for text, end in parts)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(csv_text, "_PIECE", piece)
        found = list(Text(whole.encode(encoding), encoding).lines())
    assert found == list(enumerate(whole.splitlines(), start=1))


def test_bytes_that_are_no_text_are_told_with_their_row(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_text, "_PIECE", 7)
    path = tmp_path / "log.csv"
    path.write_bytes(b"t;u\n" + b"1;2\n" * 9 + "é\n".encode("latin-1"))
    _, _, fault = csv_text.read_text(path, "utf-8")
    assert (fault.row, "0xe9" in fault.got) == (11, True)


def same(first, second):
    assert first.channels.keys() == second.channels.keys()
    for name, channel in first.channels.items():
        other = second.channels[name]
        if channel.is_text:
            assert channel.values.tolist() == other.values.tolist()
        else:
            np.testing.assert_array_equal(channel.values, other.values)
        assert dict(channel.odd) == dict(other.odd)
        np.testing.assert_array_equal(channel.lines, other.lines)
        assert (channel.near is None) == (other.near is None)
        if channel.near is not None:
            np.testing.assert_array_equal(channel.near[1], other.near[1])


LOG = """\
# made by hand
stamp;u [V];state;odd;
{rows}end of log
and more words
"""


@hypothesis.settings(max_examples=30)
@hypothesis.given(cells=st.integers(1, 60), odd=st.sets(st.integers(0, 29), max_size=9))
def test_blocks_of_any_size_make_the_same_channels(tmp_path_factory, cells, odd):
    path = tmp_path_factory.mktemp("log") / "log.csv"
    row = "17{k:08d}.{k:03d}123;{k},5;word {k};{last};\n"
    lines = [
        row.format(k=k, last="off" if k in odd else k).replace(".", ",") for k in range(30)
    ]
    path.write_text(LOG.format(rows="".join(lines)), encoding="utf-8")
    (whole, _), patch = csv_log.read_csv(path, Dialect()), pytest.MonkeyPatch()
    with patch.context() as patched:
        patched.setattr(csv_log, "_CELLS", cells)
        made, _ = csv_log.read_csv(path, Dialect())
    same(whole, made)
    assert made.channels["state"].is_text
    assert set(made.channels["odd"].odd) == odd
    assert "2 lines of words" in made.notes[0]
    np.testing.assert_allclose(np.diff(made.channels["stamp"].near[1]), 1.001, atol=1e-9)


def test_a_log_of_more_cells_than_are_held_is_one_fault(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_log, "_MOST", 50)
    path = tmp_path / "log.csv"
    path.write_text("t,u\n" + "".join(f"{k},1\n" for k in range(26)))
    log, (fault,) = csv_log.read_csv(path, Dialect())
    assert log is None
    assert fault.got == "26 rows of 2 columns"


@pytest.mark.parametrize(
    "form", ["10:{:02d}:00", "30.11.2026 10:{:02d}", "2026-11-30T10:{:02d}Z"]
)
def test_stamps_are_the_same_whatever_is_parsed_together(form, monkeypatch):
    texts = np.array([form.format(minute) for minute in range(40)])
    epoch, seconds = stamps.from_texts(texts)
    monkeypatch.setattr(stamps, "_BLOCK", 7)
    assert stamps.from_texts(texts)[0] == epoch
    np.testing.assert_array_equal(stamps.from_texts(texts)[1], seconds)
    np.testing.assert_array_equal(np.diff(seconds), 60.0)
