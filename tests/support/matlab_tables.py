"""MAT files with tables and timetables, written byte by byte as MATLAB keeps its objects.

A variable is a reference; the properties of all objects stand in a cell array of the class
`FileWrapper__`, whose first cell says which is whose. See `identification.bring.files.mat`.
"""

import dataclasses
import io
import pathlib
import struct
import uuid

import h5py
import numpy as np
import scipy.io

CLASSES = ("table", "timetable", "duration", "datetime")
SAVED = ("timetable",)
"""Classes that save a structure in their place."""


@dataclasses.dataclass
class Objects:
    """Objects, and the variables that they are."""

    made: list = dataclasses.field(default_factory=list)
    variables: dict = dataclasses.field(default_factory=dict)

    def add(self, kind, variable="", **properties):
        """The reference of a new object."""
        self.made.append((kind, properties))
        kind_number = CLASSES.index(kind) + 1
        numbers = np.array([[0xDD000000, 2, 1, 1, len(self.made), kind_number]], np.uint32).T
        if variable:
            self.variables[variable] = (kind, numbers)
        return numbers

    def table(self, variable, columns, units, rows=None):
        count = len(next(iter(columns.values()))) if rows is None else rows
        self.add(
            "table",
            variable,
            data=cells([as_column(each) for each in columns.values()]),
            nrows=np.array([[float(count)]]),
            varnames=cells([text(name) for name in columns]),
            props=structure(VariableUnits=cells([text(unit) for unit in units])),
        )

    def timetable(self, variable, times, columns, units):
        saved = {
            "data": cells([as_column(each) for each in columns.values()]),
            "numRows": np.array([[float(len(next(iter(columns.values()))))]]),
            "dimNames": cells([text("Time"), text("Variables")]),
            "varNames": cells([text(name) for name in columns]),
            "varUnits": cells([text(unit) for unit in units]),
            "rowTimes": times,
        }
        self.add("timetable", variable, any=structure(**saved))

    def duration(self, seconds, variable=""):
        return self.add("duration", variable, millis=as_column(1e3 * np.asarray(seconds)))

    def even(self, begin, rate):
        """Times of rows at a rate; MATLAB saves no property that is as usual."""
        origin = self.duration([begin]) if begin else self.add("duration")
        return structure(
            origin=origin,
            specifiedAsRate=np.array([[1]], np.uint8),
            stepSize=self.duration([1 / rate]),
            sampleRate=np.array([[float(rate)]]),
        )

    def cells(self):
        """The store's cells."""
        names = [*CLASSES, *dict.fromkeys(name for _, held in self.made for name in held)]
        contents, blocks, rows = [], ([], []), [[0] * 6]
        for kind, held in self.made:
            saved = kind in SAVED
            block = [len(held)]
            for name, value in held.items():
                block += [names.index(name) + 1, 1, len(contents)]
                contents.append(value)
            mine = blocks[0] if saved else blocks[1]
            mine.append(block)
            which = (len(mine), 0) if saved else (0, len(mine))
            rows.append([CLASSES.index(kind) + 1, 0, 0, *which, 0])
        classes = [[0, number, 0, 0] for number in range(len(CLASSES) + 1)]
        usual = [structure(millis=np.zeros((1, 1))) for _ in range(len(CLASSES) + 1)]
        head = linked(names, [classes, region(blocks[0]), rows, region(blocks[1]), [[0, 0]]])
        none = np.zeros((0, 0))
        return [head, none, *contents, none, none, cells(usual)]


def linked(names, regions):
    """The first cell: names, and 32-bit integers in regions."""
    texts = b"".join(name.encode() + b"\0" for name in names)
    texts += bytes(-len(texts) % 8)
    packed = [np.array(each, "<i4").tobytes() for each in regions]
    begin = 40 + len(texts)
    places = [begin + sum(map(len, packed[:k])) for k in range(len(packed) + 1)]
    places += [places[-1]] * (8 - len(places))
    content = struct.pack("<10i", 4, len(names), *places) + texts + b"".join(packed)
    return np.frombuffer(content, np.uint8)[:, None]


def region(blocks):
    """Blocks of properties, each filled up to eight bytes."""
    numbers = [0, 0]
    for block in blocks:
        numbers += [*block, *([0] if len(block) % 2 else [])]
    return numbers


def cells(values):
    made = np.empty((1, len(values)), object)
    made[0, :] = values
    return made


def structure(**fields):
    made = np.empty((1, 1), [(name, object) for name in fields])
    made[0, 0] = tuple(fields.values())
    return made


def text(words):
    return np.array([words]) if words else np.zeros((0, 0))


def as_column(values):
    values = np.asarray(values)
    return values if values.dtype == np.uint32 or values.ndim == 2 else values[:, None]


def element(kind, content):
    """A data element of MAT 5, filled up to eight bytes."""
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def saved(value):
    """An array as an element, by SciPy."""
    file = io.BytesIO()
    scipy.io.savemat(file, {"x": value})
    return file.getvalue()[128:]


def opaque(name, kind, value):
    texts = b"".join(element(1, each.encode()) for each in (name, "MCOS", kind))
    return element(14, element(6, struct.pack("<II", 17, 0)) + texts + saved(value))


def nameless(kind, head, content):
    """A variable of one row without a name."""
    flags, size = element(6, struct.pack("<II", kind, 0)), element(5, struct.pack("<ii", *head))
    return element(14, flags + size + element(1, b"") + content)


def write_mat5(path: pathlib.Path, objects: Objects) -> None:
    """As `save -v6` writes them; `-v7` packs each variable."""
    store = np.empty((len(objects.cells()), 1), object)
    store[:, 0] = objects.cells()
    field = element(5, struct.pack("<i", 8)) + element(1, b"MCOS".ljust(8, b"\0"))
    inner = nameless(2, (1, 1), field + opaque("", "FileWrapper__", store))
    hidden = nameless(9, (1, len(inner) + 8), element(2, b"\0\1IM" + bytes(4) + inner))
    header = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\0\1IM"
    named = [opaque(name, *value) for name, value in objects.variables.items()]
    path.write_bytes(header + b"".join(named) + hidden)


def write_mat73(path: pathlib.Path, objects: Objects) -> None:
    """As `save -v7.3` writes them."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, (kind, numbers) in objects.variables.items():
            made = file.create_dataset(name, data=numbers.T)
            made.attrs["MATLAB_class"] = np.bytes_(kind)
            made.attrs["MATLAB_object_decode"] = np.int32(3)
        file.create_group("#refs#")
        store = references(file, objects.cells())
        made = file.create_dataset("#subsystem#/MCOS", data=store, dtype=h5py.ref_dtype)
        made.attrs["MATLAB_class"] = np.bytes_("FileWrapper__")
        made.attrs["MATLAB_object_decode"] = np.int32(3)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def references(file, values):
    made = np.empty((1, len(values)), h5py.ref_dtype)
    for place, value in enumerate(values):
        name = f"#refs#/{uuid.uuid4().hex}"
        made[0, place] = stored(file, name, value).ref
    return made


def stored(file, name, value):
    """A value under a name, by MATLAB's classes."""
    if value.dtype.names:
        group = file.create_group(name)
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for field in value.dtype.names:
            stored(file, f"{name}/{field}", value[0, 0][field])
        return group
    kind, data = "double", value.T
    if value.dtype == object:
        kind, data = "cell", references(file, list(value.ravel()))
        made = file.create_dataset(name, data=data, dtype=h5py.ref_dtype)
    elif value.dtype.kind == "U":
        kind = "char"
        made = file.create_dataset(name, data=np.array([[ord(c)] for c in value[0]], np.uint16))
    else:
        made = file.create_dataset(name, data=data if value.size else np.zeros(2, np.uint64))
        if not value.size:
            made.attrs["MATLAB_empty"] = np.uint8(1)
    made.attrs["MATLAB_class"] = np.bytes_(kind)
    return made
