"""Logs of one axis: units, and what is wrong with a bad one."""

import math

import numpy as np
import pytest

from identification.axis.log import read_axis_log

ROWS = [(0.001 * i, 0.5 * i, 0.01 * i**2) for i in range(20)]


def write(path, header="t [s],voltage [V],position [m]", rows=ROWS):
    lines = [header, *(",".join(str(cell) for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_log_in_si_units_is_read_as_it_stands(tmp_path):
    log = read_axis_log(write(tmp_path / "log.csv"))
    expected = np.array(ROWS).T
    np.testing.assert_array_equal([log.time, log.voltage, log.position], expected)
    assert log.position_unit == "m"


@pytest.mark.parametrize(
    ("unit", "si_unit", "factor"),
    [("mm", "m", 1e-3), ("cm", "m", 1e-2), ("rad", "rad", 1.0), ("rev", "rad", 2 * math.pi)],
)
def test_units_are_converted(tmp_path, unit, si_unit, factor):
    path = write(tmp_path / "log.csv", header=f"t [ms],voltage [mV],position [{unit}]")
    log = read_axis_log(path)
    expected = np.array(ROWS).T * [[1e-3], [1e-3], [factor]]
    # The reader rounds a decimal number once, the product here rounds it twice.
    ulp = np.spacing(expected)
    assert np.all(np.abs(np.array([log.time, log.voltage, log.position]) - expected) <= ulp)
    assert log.position_unit == si_unit


def test_other_columns_and_their_order_do_not_matter(tmp_path):
    rows = [("a", position, voltage, time) for time, voltage, position in ROWS]
    header = "note,position [m],voltage [V],t [s]"
    log = read_axis_log(write(tmp_path / "log.csv", header=header, rows=rows))
    np.testing.assert_array_equal(log.position, [row[2] for row in ROWS])


def spoiled(line, cell, value):
    rows = [list(row) for row in ROWS]
    rows[line - 2][cell] = value
    return rows


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"header": "t,voltage [V],position [m]"}, r"row 1, column 't': .*\"t \[s\]\""),
        ({"header": "t [s],voltage [kV],position [m]"}, r"column 'voltage \[kV\]': a unit"),
        ({"header": "t [s],u [V],position [m]"}, "column 'voltage' is missing"),
        ({"header": "t [s],voltage [V],voltage [V],position [m]"}, "a second 'voltage'"),
        ({"header": "t [s];voltage [V];position [m]"}, "commas between columns"),
        ({"rows": spoiled(7, 1, "")}, r"row 7, column 'voltage \[V\]': an empty cell"),
        ({"rows": spoiled(7, 2, "nan")}, r"row 7, column 'position \[m\]': .*got 'nan'"),
        ({"rows": spoiled(9, 1, "1,5")}, "row 9: .*got 4 cells, expected 3"),
        ({"rows": spoiled(5, 0, 0.002)}, r"row 5, column 't \[s\]': .*got 0.002 after 0.002"),
        ({"rows": ROWS[:9]}, "9 samples, expected at least 16"),
        ({"rows": [("x", "y", "z")] * 20}, "and 50 more"),
    ],
)
def test_a_fault_is_named_with_its_file_and_place(tmp_path, changes, message):
    path = write(tmp_path / "bad.csv", **changes)
    with pytest.raises(ValueError, match=message) as caught:
        read_axis_log(path)
    assert str(path) in str(caught.value)


def test_an_empty_file_is_refused(tmp_path):
    path = tmp_path / "empty.csv"
    path.write_text("")
    with pytest.raises(ValueError, match="the file is empty"):
        read_axis_log(path)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "binary.csv"
    path.write_bytes(b"t [s],voltage [V]\xff\xfe")
    with pytest.raises(ValueError, match="not text in UTF-8, got the byte 0xff"):
        read_axis_log(path)
