"""Plain data on their way to whoever computes with them, and back.

A pickle would be simpler, and is a program: whoever can put one in a worker's way has the
worker. Numbers and texts in JSON, and arrays as their bytes, can be nothing else.
"""

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

_MARK = b"scdpr parcel 1\n"


class Parcel(NamedTuple):
    """Facts and arrays by their names."""

    facts: Mapping[str, Any]
    """What JSON can hold."""
    arrays: Mapping[str, np.ndarray] = {}
    """Arrays of numbers, of bytes, or of records of numbers."""


def packed(parcel: Parcel) -> bytes:
    """A parcel as bytes, the same for equal ones.

    Args:
        parcel: The parcel.

    Returns:
        Its bytes.
    """
    arrays = {name: np.ascontiguousarray(array) for name, array in parcel.arrays.items()}
    head = {
        "facts": parcel.facts,
        "arrays": [
            [name, np.lib.format.dtype_to_descr(array.dtype), np.shape(parcel.arrays[name])]
            for name, array in arrays.items()
        ],
    }
    text = json.dumps(head, sort_keys=True).encode()
    parts = [_MARK, len(text).to_bytes(8, "big"), text]
    return b"".join([*parts, *(array.tobytes() for array in arrays.values())])


def unpacked(content: bytes) -> Parcel:
    """A parcel from its bytes.

    Args:
        content: The bytes.

    Returns:
        The parcel; its arrays can't be written to.

    Raises:
        ValueError: If they aren't a whole parcel's.
    """
    begin = len(_MARK) + 8
    if not content.startswith(_MARK) or len(content) < begin:
        raise ValueError("no parcel, expected facts and arrays as `packed` writes them")
    end = begin + int.from_bytes(content[len(_MARK) : begin], "big")
    head = json.loads(content[begin:end])
    arrays = {}
    for name, described, shape in head["arrays"]:
        dtype, count = np.lib.format.descr_to_dtype(_tuples(described)), math.prod(shape)
        if dtype.hasobject or end + count * dtype.itemsize > len(content):
            raise ValueError(f"array {name!r} of a parcel isn't whole, or isn't of numbers")
        arrays[name] = np.frombuffer(content, dtype, count, end).reshape(shape)
        end += count * dtype.itemsize
    if end != len(content):
        raise ValueError(f"a parcel has {len(content) - end} bytes too many")
    return Parcel(head["facts"], arrays)


def _tuples(described: Any) -> Any:
    """A dtype's description as NumPy wants it, which JSON knows lists of only."""
    if isinstance(described, str):
        return described
    fields = ((name, _tuples(kind), *map(tuple, shape)) for name, kind, *shape in described)
    return list(fields)
