import os
import pathlib
import time

import nptdms
import numpy as np
import pytest
import scipy.io

from identification.bring.drive_log import import_drive_stream
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from identification.bring.streams.piece import find

SHARED = pathlib.Path(__file__).parents[4] / "shared" / "data"
HOSTILE = SHARED / "hostile"
NAMES = ("mat_hang.mat", "mat_segv1.mat", "mat_typeerror.mat", "mat_zlib_error.mat",
         "tdms_keyerror.tdms", "tdms_structerror.tdms")  # fmt: skip


def opened(*paths):
    return open_logs([(path, Dialect()) for path in paths])


@pytest.mark.skipif(not HOSTILE.exists(), reason="the shared damaged files aren't there")
def test_damaged_files_are_one_fault_each_and_the_others_are_read(tmp_path):
    good = tmp_path / "good.mat"
    scipy.io.savemat(good, {"x": np.arange(5.0)})
    logs, faults = opened(good, *(HOSTILE / name for name in NAMES))
    assert list(logs) == [good]
    assert sorted(fault.file for fault in faults) == sorted(str(HOSTILE / n) for n in NAMES)


def mutants(content, random, count):
    for _ in range(count):
        made = bytearray(content)
        for _ in range(random.integers(1, 4)):
            made[random.integers(len(made))] = random.integers(256)
        yield bytes(made[: random.integers(len(made) // 2, len(made) + 1)])


def test_no_damage_drawn_ends_the_process(tmp_path):
    random = np.random.default_rng(11)
    struct = {"a": np.arange(40.0), "b": {"c": np.arange(9), "note": "text"}}
    scipy.io.savemat(tmp_path / "log.mat", {"log": struct})
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as writer:
        channel = nptdms.ChannelObject("g", "c", np.arange(40.0), {"wf_increment": 1e-3})
        writer.write_segment([channel])
    paths = []
    for suffix in (".mat", ".tdms"):
        content = (tmp_path / f"log{suffix}").read_bytes()
        for number, mutant in enumerate(mutants(content, random, 6)):
            paths.append(tmp_path / f"mutant{number}{suffix}")
            paths[-1].write_bytes(mutant)
    logs, faults = opened(*paths)
    assert len(logs) + len(faults) == len(paths)
    assert {fault.file for fault in faults} == {str(p) for p in paths if p not in logs}


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "log.csv")
    began = time.monotonic()
    _, (fault,) = opened(tmp_path / "log.csv")
    assert fault.got == "a pipe"
    assert time.monotonic() - began < 60


@pytest.mark.parametrize(
    ("content", "got"),
    [
        (b"PK\x03\x04....", "workbook"),
        (b"\0" * 5000, "zero bytes"),
        (b"", "nothing"),
        (b"only words\nin here\n", "only words"),
    ],
)
def test_what_is_no_log_is_told_by_its_content(content, got, tmp_path):
    (tmp_path / "log.csv").write_bytes(content)
    _, (fault,) = opened(tmp_path / "log.csv")
    assert got in fault.got


@pytest.mark.skipif(not SHARED.exists(), reason="the shared cases aren't there")
def test_simulinks_layouts_have_a_way_in():
    folder = SHARED / "cases" / "mat-simulink-structure"
    logs, faults = opened(folder / "arr.mat", folder / "swt.mat", folder / "swa.mat")
    assert not faults
    arrays, muxed, several = logs.values()
    for log, names in (
        (arrays, ("simout(:,2)", "simout[:, 1]")),
        (muxed, ("ScopeData.signals.values(:,1)", "ScopeData.signals(1).values[:, 0]")),
        (several, ("ScopeData.signals(1).values", "ScopeData.signals[0].values(:,1)")),
    ):
        numbers = [find(log, name)[0].values for name in names]
        assert all(each.shape == (2000,) for each in numbers)
        np.testing.assert_array_equal(*numbers)
    np.testing.assert_array_equal(
        find(arrays, "simout(:,2)")[0].values,
        find(several, "ScopeData.signals(1).values")[0].values,
    )


@pytest.mark.skipif(not SHARED.exists(), reason="the shared cases aren't there")
def test_a_drive_stream_comes_from_a_column_of_an_array():
    path = SHARED / "cases" / "mat-simulink-structure" / "arr.mat"
    names = ("t [s]", "voltage_1 [V]", "voltage_2 [V]", "alpha_1 [rad]", "alpha_2 [rad]")
    columns = {name: f"simout(:,{k})" for k, name in enumerate(names, start=1)}
    assert import_drive_stream(path, columns=columns).angle.shape == (2000, 2)


def test_no_damage_to_a_text_is_more_than_a_fault(tmp_path):
    random = np.random.default_rng(12)
    rows = [f'{k / 1000};{k % 7},5;"{k}";RUN' for k in range(60)]
    content = "\n".join(["# rig", "t [s];u1;n;state", *rows]).encode()
    paths = []
    for number, mutant in enumerate(mutants(content, random, 80)):
        paths.append(tmp_path / f"mutant{number}.csv")
        paths[-1].write_bytes(mutant)
    (tmp_path / "long.csv").write_text('a,b\n"' + "1" * 200_000 + '",2\n1,2\n')
    paths.append(tmp_path / "long.csv")
    logs, faults = opened(*paths)
    assert {str(path) for path in paths} == {str(p) for p in logs} | {f.file for f in faults}
    assert logs
