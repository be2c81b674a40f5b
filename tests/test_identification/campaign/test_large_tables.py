"""Tables are read a few rows at a time: what a block's end cuts is read as if it weren't."""

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from identification.campaign.tables import rows
from identification.campaign.tables.columns import drive_columns
from identification.campaign.tables.table import read_table

HEADER = "t [s],voltage_1 [V],voltage_2 [V],alpha_1 [rad],alpha_2 [rad],note [1]\n"


def read(folder, text):
    path = folder / "drive.csv"
    path.write_text(text, encoding="utf-8")
    return read_table(path, drive_columns(None), file="drive.csv")


def body(count, note):
    return [f"{k / 10},{k},1.5,0,{-k},{note(k)}\n" for k in range(count)]


@hypothesis.given(
    cells=st.integers(1, 40),
    count=st.integers(2, 12),
    blank=st.lists(st.sampled_from(["\n", " ,,\n", ",,,,,\n"]), max_size=9),
    text_from=st.integers(0, 14),
)
def test_blocks_of_any_size_make_the_same_table(
    tmp_path_factory, cells, count, blank, text_from
):
    folder = tmp_path_factory.mktemp("table")
    lines = body(count, lambda k: "é" if k >= text_from else k)
    text = HEADER + "".join([*lines, *blank])
    whole, faults = read(folder, text)
    assert not faults
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rows, "_CELLS", cells)
        table, faults = read(folder, text)
    assert not faults
    assert table.extra["note [1]"].tolist() == whole.extra["note [1]"].tolist()
    assert len(table.extra["note [1]"]) == count
    for name, values in whole.values.items():
        np.testing.assert_array_equal(table.values[name], values)


@pytest.mark.parametrize(
    ("spoilt", "row", "what"),
    [
        ("7,7,7\n", 9, "another length"),
        ("\n", 9, "another length"),
        (",,,,,\n", 9, "empty cell"),
        ("0.1,1,1,0,0,0\n", 9, "doesn't increase"),
        ("9,x,1,0,0,0\n", 9, "not a number"),
        ('9,1,1,0,0,"' + 140_000 * "y" + '"\n', 9, "split into cells"),
    ],
)
def test_what_is_wrong_beyond_the_first_block_has_its_row(
    tmp_path, monkeypatch, spoilt, row, what
):
    monkeypatch.setattr(rows, "_CELLS", 12)
    lines = body(12, lambda k: k)
    table, faults = read(tmp_path, HEADER + "".join([*lines[:7], spoilt, *lines[10:]]))
    assert table is None
    assert (faults[0].row, what in faults[0].what) == (row, True), faults[0]


def test_a_header_of_more_columns_than_a_log_has_is_one_fault(tmp_path):
    table, faults = read(tmp_path, 5000 * "," + "\n" + body(3, str)[0] + body(3, str)[1])
    assert table is None
    (fault,) = faults
    assert fault.what == "too many columns"
