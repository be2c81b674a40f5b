"""MATLAB's tables, timetables, durations and datetimes as columns of numbers and texts."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from jaxtyping import Float64, Shaped

from identification.bring.files.mat.store import Store, reference_of

_MILLI = 1e-3


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """A variable of a table."""

    name: str
    """Its name; empty of an object that is one column itself."""
    values: Shaped[np.ndarray, "..."]
    """Its numbers or texts, a row each."""
    unit: str = ""
    """Its unit as the table states it."""
    epoch: int | None = None
    """Of dates: whole seconds since 1970 that its numbers [s] count from."""
    kind: str = ""
    """Class of objects that can't be read."""


def columns_of(value: Any, store: Store | None) -> tuple[Column, ...]:
    """The columns of an object.

    Args:
        value: A reference to it.
        store: The properties of the file's objects; None where there are none.

    Returns:
        The columns; none of an object that can't be read.
    """
    if store is None:
        return ()
    try:
        reader = _READERS.get(store.kind(value))
        return () if reader is None else reader(store.properties(value), store)
    except (ValueError, IndexError, KeyError):
        return ()  # Other than any that is known: its error names the way out.


def _table(held: Mapping[str, Any], store: Store) -> tuple[Column, ...]:
    units = np.ravel(held["props"])[0]["VariableUnits"]
    return _columns(held["data"], held["varnames"], units, _count(held["nrows"]), store)


def _timetable(held: Mapping[str, Any], store: Store) -> tuple[Column, ...]:
    saved = np.ravel(held["any"])[0]
    rows = _count(saved["numRows"])
    times = _row_times(saved["rowTimes"], rows, store)
    if len(times.values) != rows:
        raise ValueError("a timetable with another number of times than rows")
    first = dataclasses.replace(times, name=_texts(saved["dimNames"])[0])
    return (first, *_columns(saved["data"], saved["varNames"], saved["varUnits"], rows, store))


def _columns(data: Any, names: Any, units: Any, rows: int, store: Store) -> tuple[Column, ...]:
    """The columns of a table's parts, each with as many rows as the table."""
    cells, called, stated = list(np.ravel(data)), _texts(names), _texts(units)
    stated = stated or [""] * len(called)
    columns = []
    for cell, name, unit in zip(cells, called, stated, strict=True):
        column = _column(cell, store)
        if column is not None:
            if not column.kind and len(column.values) != rows:
                raise ValueError("a column with another number of rows than its table")
            columns.append(dataclasses.replace(column, name=name, unit=column.unit or unit))
    return tuple(columns)


def _column(cell: Any, store: Store) -> Column | None:
    """A column of a table; None of one without numbers or texts."""
    if reference_of(cell) is not None:
        kind = store.kind(cell)
        if kind in _TIMES:
            return _TIMES[kind](store.properties(cell))
        return Column(name="", values=np.zeros(0), kind=kind)
    cell = np.asarray(cell)
    if cell.dtype == object:
        texts = list(_each_text(cell))
        return None if None in texts else Column(name="", values=np.array(texts, dtype=str))
    return Column(name="", values=cell) if cell.dtype.kind in "fiub" else None


def _row_times(value: Any, rows: int, store: Store) -> Column:
    """Times of a timetable's rows: each by itself, or a first one and a step."""
    if reference_of(value) is not None:
        return _TIMES[store.kind(value)](store.properties(value))
    even = np.ravel(value)[0]
    begin = _TIMES[store.kind(even["origin"])](store.properties(even["origin"]))
    if even["specifiedAsRate"].item():
        steps = np.arange(rows) / float(even["sampleRate"].item())
    else:
        if store.kind(even["stepSize"]) != "duration":
            raise ValueError("steps of the calendar aren't of one length")
        steps = np.arange(rows) * _duration(store.properties(even["stepSize"])).values.item()
    return dataclasses.replace(begin, values=begin.values.item() + steps)


def _duration(held: Mapping[str, Any]) -> Column:
    return Column(name="", values=_numbers(held["millis"]) * _MILLI, unit="s")


def _datetime(held: Mapping[str, Any]) -> Column:
    """Dates: milliseconds since 1970, and what doubles round off them as an imaginary part."""
    whole, rest = _numbers(np.real(held["data"])), _numbers(np.imag(held["data"]))
    known = whole[np.isfinite(whole)]
    epoch = math.floor(known[0] * _MILLI) if len(known) else 0
    return Column(name="", values=(whole - 1e3 * epoch + rest) * _MILLI, unit="s", epoch=epoch)


_TIMES: Mapping[str, Callable[[Mapping[str, Any]], Column]] = {
    "duration": _duration,
    "datetime": _datetime,
}
_READERS: Mapping[str, Callable[[Mapping[str, Any], Store], tuple[Column, ...]]] = {
    "table": _table,
    "timetable": _timetable,
    "duration": lambda held, store: (_duration(held),),
    "datetime": lambda held, store: (_datetime(held),),
}


def _numbers(values: Any) -> Float64[np.ndarray, " rows"]:
    return np.asarray(values, dtype=np.float64).ravel()


def _count(value: Any) -> int:
    return int(np.asarray(value).item())


def _texts(cells: Any) -> list[str]:
    """A cell array's texts."""
    texts = list(_each_text(np.asarray(cells, dtype=object)))
    if None in texts:
        raise ValueError("a name that isn't a text")
    return [text or "" for text in texts]


def _each_text(cells: Any) -> Iterator[str | None]:
    """The text of each cell: empty of an empty one, None of one that has none."""
    for cell in cells.ravel():
        content = np.asarray(cell)
        if not content.size:
            yield ""
        elif content.dtype.kind == "U" and content.size == 1:
            yield str(content.item())
        else:
            yield None
