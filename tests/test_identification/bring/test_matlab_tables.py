"""MATLAB's tables and timetables are read as they were saved, or not at all."""

import contextlib

import numpy as np
import pytest
from matlab_tables import Objects, write_mat5, write_mat73

from identification.bring.drive_log import import_drive_stream
from identification.bring.files.mat.hdf5 import read_hdf5
from identification.bring.files.mat.level5 import read_level5
from identification.bring.files.mat.store import Store
from identification.bring.files.mat.tables import columns_of

NAMES = ("u1", "u2", "a1", "a2")
STREAM = ("voltage_1 [V]", "voltage_2 [V]", "alpha_1 [rad]", "alpha_2 [rad]")
COUNT = 40
NUMBERS = {name: np.sin(np.arange(COUNT) + k) for k, name in enumerate(NAMES)}
UNITS = ("V", "V", "rad", "")
FORMATS = pytest.mark.parametrize(
    ("write", "read"), [(write_mat5, read_level5), (write_mat73, read_hdf5)]
)


def objects():
    """Timetables with a rate and with times of their own, a table, and times alone."""
    made = Objects()
    made.timetable("even", made.even(0.0, 1000.0), NUMBERS, UNITS)
    made.timetable("late", made.even(2.5, 1000.0), NUMBERS, UNITS)
    made.timetable("own", made.duration(0.002 * np.arange(COUNT)), NUMBERS, UNITS)
    made.table("rig", {"t": 0.004 * np.arange(COUNT), **NUMBERS}, ("s", *UNITS))
    made.table("wrong", NUMBERS, UNITS, rows=COUNT + 1)
    made.duration(np.arange(3.0), "wait")
    dates = 1.7644752e12 + np.array([0.0, 20.0, 40.0]) + 1j * np.array([0.0, 1e-4, 0.0])
    made.add("datetime", "when", data=dates[:, None])
    return made


@FORMATS
def test_a_timetable_is_imported_as_its_columns(tmp_path, write, read):
    write(tmp_path / "log.mat", objects())
    columns = {"t [s]": "even.Time"}
    columns |= {to: f"even.{name}" for to, name in zip(STREAM, NAMES, strict=True)}
    stream = import_drive_stream(tmp_path / "log.mat", columns=columns)
    np.testing.assert_allclose(stream.time, 1e-3 * np.arange(COUNT), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(stream.voltage[:, 0], NUMBERS["u1"])
    np.testing.assert_array_equal(stream.angle[:, 1], NUMBERS["a2"])


@FORMATS
def test_times_and_units_of_tables_are_theirs(tmp_path, write, read):
    write(tmp_path / "log.mat", objects())
    channels = {channel.name: channel for channel in read(tmp_path / "log.mat")}
    for name, begin, step in (
        ("late.Time", 2.5, 1e-3),
        ("own.Time", 0.0, 2e-3),
        ("rig.t", 0.0, 4e-3),
    ):
        times = begin + step * np.arange(COUNT)
        np.testing.assert_allclose(channels[name].values, times, rtol=0, atol=1e-15)
        assert channels[name].unit == "s"
    assert [channels[f"rig.{name}"].unit for name in NAMES] == list(UNITS)
    np.testing.assert_array_equal(channels["wait"].values, [0.0, 1.0, 2.0])
    when = channels["when"]
    assert when.epoch == 1764475200
    # Doubles count milliseconds since 1970 to 2e-4: the rest is beside them.
    np.testing.assert_allclose(when.values, [0.0, 0.0200001, 0.04], rtol=0, atol=1e-12)


@FORMATS
def test_a_table_that_contradicts_itself_is_named_with_its_way_out(tmp_path, write, read):
    write(tmp_path / "log.mat", objects())
    channels = {channel.name: channel for channel in read(tmp_path / "log.mat")}
    assert "table2struct(wrong" in channels["wrong"].missing
    assert "wrong.u1" not in channels


def test_a_damaged_store_gives_the_numbers_that_are_there_or_none():
    made = objects()
    cells, random = made.cells(), np.random.default_rng(7)
    references = [numbers for _, numbers in made.variables.values()]
    whole = {each.tobytes() for r in references for each in numbers_of(r, Store.of(cells))}
    stores = 0
    for _ in range(400):
        head = cells[0].copy()
        places = random.integers(len(head), size=random.integers(1, 4))
        head[places, 0] = random.integers(256, size=len(places))
        with contextlib.suppress(ValueError, IndexError):  # what its readers take for none
            store = Store.of([head, *cells[1:]])
            stores += 1
            for reference in references:
                for values in numbers_of(reference, store):
                    assert values.tobytes() in whole
    assert stores > 100


def numbers_of(reference, store):
    return [column.values for column in columns_of(reference, store) if column.values.size > 1]
