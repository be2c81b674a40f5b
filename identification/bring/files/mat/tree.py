"""A MAT file's variables as channels: structures and cells walked through to their arrays.

A path is MATLAB's own but for its indices, which count from 0 in square brackets:
`ScopeData.signals[2].values`. Structures that aren't arrays have none.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from identification.bring.files.channel import Channel
from identification.bring.files.mat.objects import way_out
from identification.bring.files.mat.store import Store
from identification.bring.files.mat.tables import columns_of

LABELS = ("label", "Name", "name", "Label", "Path", "title")
"""Members of a structure that name its signal, the first that is there."""
UNITS = ("unit", "Unit", "units", "Units")
"""Members that state a unit."""


def channels(variables: Mapping[str, Any], store: Store | None = None) -> list[Channel]:
    """Channels of a MAT file's variables.

    Args:
        variables: SciPy's arrays by name: of numbers, of structures (with fields), of objects
            (cells), of characters.
        store: The properties of MATLAB's own objects; None where the file has none.

    Returns:
        A channel for each array of numbers or texts, and for each object that can't be read.
    """
    return [
        each for name, value in variables.items() for each in _walk(name, value, "", "", store)
    ]


def _walk(
    path: str, value: Any, label: str, unit: str, store: Store | None
) -> Iterator[Channel]:
    """The channels of a value and of what it holds."""
    kind = class_of(value)
    if kind:
        yield from _of_object(name_of(value) or path, value, kind, label, store)
        return
    if not isinstance(value, np.ndarray | np.void):
        return  # a sparse matrix, or nothing at all: no log is one
    array = np.asarray(value)
    if array.dtype.names:
        for place, record in _items(path, array):
            fields = {name: record[name] for name in array.dtype.names}
            label_of, unit_of = (_first_text(fields, names) for names in (LABELS, UNITS))
            for name, field in fields.items():
                yield from _walk(
                    f"{place}.{name}", field, label_of or label, unit_of or unit, store
                )
    elif array.dtype == object:
        for place, item in _items(path, array):
            yield from _walk(place, item, label, unit, store)
    elif array.dtype.kind in "fiub" and array.size:
        numbers = _squeezed(array.astype(np.float64))
        yield Channel(name=path, values=numbers, label=label, unit=unit)
    elif array.dtype.kind == "U" and array.size > 1:
        texts = np.char.strip(array.ravel())
        yield Channel(name=path, values=texts, label=label, unit=unit)


def _of_object(
    path: str, value: Any, kind: str, label: str, store: Store | None
) -> Iterator[Channel]:
    """The columns of a table, or what to do with an object that can't be read."""
    columns = columns_of(value, store)
    if not columns:
        yield Channel(name=path, values=np.zeros(0), missing=way_out(path, kind))
    for column in columns:
        place = f"{path}.{column.name}" if column.name else path
        if column.kind:
            missing = way_out(place, column.kind)
            yield Channel(name=place, values=np.zeros(0), missing=missing)
            continue
        values = column.values
        if not values.size:
            continue
        if values.dtype.kind != "U":
            values = _squeezed(values.astype(np.float64))
        yield Channel(
            name=place, values=values, label=label, unit=column.unit, epoch=column.epoch
        )


def class_of(value: Any) -> str:
    """MATLAB's class of an object that only MATLAB knows.

    Args:
        value: What SciPy made of it.

    Returns:
        The class, empty of anything else.
    """
    names = getattr(getattr(value, "dtype", None), "names", None) or ()
    if {"s0", "s1", "s2", "arr"} <= set(names):
        record = np.asarray(value).ravel()[0]
        return _text(record["s2"])
    return ""


def name_of(value: Any) -> str:
    """The variable that an object is: SciPy keeps it under another name.

    Args:
        value: What SciPy made of it.

    Returns:
        Its name, empty where it is a part of something.
    """
    return _text(np.asarray(value).ravel()[0]["s0"])


def _items(path: str, array: np.ndarray) -> Iterator[tuple[str, Any]]:
    """What an array of structures or cells holds, with the path of each."""
    flat = array.ravel(order="F")
    for index, item in enumerate(flat):
        yield (path if flat.size == 1 else f"{path}[{index}]"), item


def _squeezed(array: np.ndarray) -> np.ndarray:
    """A row or column as a row; other arrays as they are."""
    return array.ravel() if sum(size > 1 for size in array.shape) <= 1 else np.squeeze(array)


def _first_text(fields: Mapping[str, Any], names: tuple[str, ...]) -> str:
    return next((_text(fields[name]) for name in names if name in fields), "")


def _text(value: Any) -> str:
    """A text of MATLAB's, empty for anything else."""
    array = np.asarray(value)
    while array.dtype == object and array.size == 1:
        array = np.asarray(array.ravel()[0])
    if array.dtype.kind == "S" and array.size == 1:
        return array.ravel()[0].decode(errors="replace")
    return str(array.ravel()[0]) if array.dtype.kind == "U" and array.size == 1 else ""
