"""Objects that only MATLAB reads are told with the line that makes a structure of them."""

import pathlib
import struct
import zlib

import h5py
import numpy as np
import pytest

from identification.bring.drive_log import import_drive_stream
from identification.campaign.faults import CampaignError

COLUMNS = {
    "t [s]": "rig.t",
    "voltage_1 [V]": "rig.u1",
    "voltage_2 [V]": "rig.u2",
    "alpha_1 [rad]": "rig.a1",
    "alpha_2 [rad]": "rig.a2",
}
LINES = {
    "table": 'log = table2struct(rig, "ToScalar", true);',
    "timetable": 'log = table2struct(timetable2table(rig), "ToScalar", true);',
    "timeseries": 'log = struct("time", rig.Time, "data", rig.Data);',
}


def element(kind: int, content: bytes) -> bytes:
    """A data element of MAT 5, filled up to eight bytes."""
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def mat5(path: pathlib.Path, kind: str) -> None:
    """A variable `rig` of a class of MATLAB's own, as `save -v7` writes it."""
    texts = b"".join(element(1, each.encode()) for each in ("rig", "MCOS", kind))
    numbers = element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", 1, 1))
    inner = element(14, numbers + element(1, b"") + element(9, struct.pack("<d", 1.0)))
    opaque = element(14, element(6, struct.pack("<II", 17, 0)) + texts + inner)
    header = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124)
    packed = element(15, zlib.compress(opaque)).rstrip(b"\0")
    path.write_bytes(header + struct.pack("<HH", 0x0100, 0x4D49) + packed)


def mat73(path: pathlib.Path, kind: str) -> None:
    """The same as `save -v7.3` writes it."""
    with h5py.File(path, "w", userblock_size=512) as file:
        made = file.create_dataset("rig", data=np.zeros((1, 6), np.uint32))
        made.attrs["MATLAB_class"] = np.bytes_(kind)
        made.attrs["MATLAB_object_decode"] = np.int32(3)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


@pytest.mark.parametrize(
    ("kind", "written"),
    [("table", mat5), ("table", mat73), ("timetable", mat5), ("timeseries", mat73)],
)
def test_an_object_is_named_with_the_line_that_exports_it(tmp_path, kind, written):
    path = tmp_path / "log.mat"
    written(path, kind)
    with pytest.raises(CampaignError) as error:
        import_drive_stream(path, columns=COLUMNS)
    said = str(error.value)
    assert f"MATLAB's class {kind}" in said
    assert LINES[kind] in said
    assert 'save("log.mat", "log", "-v7")' in said
    if "table" in kind:
        # What a column of times or of texts would be is an object again.
        assert "log.(f{1}) = seconds(v)" in said
        assert "rmfield(log, f{1})" in said
