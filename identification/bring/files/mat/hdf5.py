"""MAT files of version 7.3, which are HDF5, in the child process.

Structures are groups, arrays of structures groups of references, cells datasets of references;
arrays are stored with their dimensions turned round. What `MATLAB_class` says is heeded where
it is there.
"""

import pathlib
from typing import Any

import h5py
import numpy as np

from identification.bring.files.channel import Channel
from identification.bring.files.mat.store import Store
from identification.bring.files.mat.tree import channels

_DEEPEST = 24
"""Structures inside of each other; a reference that leads back to itself has no end."""
_OBJECT = [("s0", "O"), ("s1", "O"), ("s2", "O"), ("arr", "O")]
"""How SciPy shows an object that only MATLAB knows."""
_CLASSES = ("function_handle", "table", "timetable", "timeseries", "string", "datetime")


def read_hdf5(path: pathlib.Path) -> list[Channel]:
    """Channels of a MAT file of version 7.3.

    Args:
        path: The file.

    Returns:
        Every array of numbers or texts, by its path through structures and cells.
    """
    with h5py.File(path, "r") as file:
        return channels(
            {name: _value(file, file[name], 0) for name in _names(file)}, _store(file)
        )


def _store(file: Any) -> Store | None:
    """The properties of the file's objects; None where there are none that can be read."""
    item = file.get("#subsystem#/MCOS")
    if not isinstance(item, h5py.Dataset) or h5py.check_ref_dtype(item.dtype) is None:
        return None
    try:
        return Store.of([_value(file, file[ref], 1) for ref in np.ravel(item[()])])
    except (ValueError, IndexError):
        return None


def _names(group: Any) -> list[str]:
    """A group's own members; those with # are MATLAB's store of references."""
    return [name for name in group if not name.startswith("#")]


def _value(file: Any, item: Any, depth: int) -> np.ndarray:
    """A group or dataset as SciPy would give it."""
    if depth > _DEEPEST:
        raise ValueError("structures inside of each other without end")
    kind = _attribute(item, "MATLAB_class")
    if "MATLAB_object_decode" in item.attrs or kind in _CLASSES:
        numbers = np.asarray(item[()]).T if isinstance(item, h5py.Dataset) else None
        made = np.zeros(1, dtype=_OBJECT)
        made[0] = (b"", b"MCOS", kind, numbers)
        return made
    if isinstance(item, h5py.Group):
        return _structure(file, item, depth)
    if item.attrs.get("MATLAB_empty", 0):
        return np.zeros(0)
    content = item[()]
    if h5py.check_ref_dtype(item.dtype) is not None:
        return _each([_value(file, file[ref], depth + 1) for ref in np.ravel(content)])
    array = np.asarray(content).T
    if kind == "char":
        return _characters(array)
    if array.dtype.kind in "SO":
        return np.array([_decoded(each) for each in array.ravel()])
    return array


def _structure(file: Any, group: Any, depth: int) -> np.ndarray:
    """A structure, or an array of them where its fields are references to as many."""
    names = _names(group)
    fields, sizes = {}, set()
    for name in names:
        item = group[name]
        referring = (
            isinstance(item, h5py.Dataset)
            and h5py.check_ref_dtype(item.dtype) is not None
            and _attribute(item, "MATLAB_class") != "cell"
        )
        sizes.add(item.size if referring else None)
        if referring:
            fields[name] = [_value(file, file[r], depth + 1) for r in np.ravel(item[()])]
        else:
            fields[name] = [_value(file, item, depth + 1)]
    count = next(iter(sizes)) if len(sizes) == 1 and None not in sizes else 1
    made = np.zeros(count, dtype=[(name, "O") for name in names])
    for name, values in fields.items():
        for place in range(count):
            whole = len(values) == count
            made[name][place] = values[place] if whole else _each(values)
    return made


def _each(values: list[np.ndarray]) -> np.ndarray:
    """A cell array."""
    made = np.empty(len(values), dtype=object)
    made[:] = values
    return made


def _characters(codes: np.ndarray) -> np.ndarray:
    """MATLAB's characters as texts, one a row."""
    rows = np.atleast_2d(codes.astype(np.uint32))
    return np.array(["".join(map(chr, row)) for row in rows])


def _decoded(text: Any) -> str:
    return text.decode(errors="replace") if isinstance(text, bytes) else str(text)


def _attribute(item: Any, name: str) -> str:
    return _decoded(item.attrs.get(name, b""))
