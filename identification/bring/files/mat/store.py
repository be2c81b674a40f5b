"""Where a MAT file keeps the properties of objects: a store that all of them share.

The variable of an object is a reference, its number and its class's. The store is a cell array.
Its first cell says in 32-bit integers which other cell is which property of which object. No
document of MATLAB's says so; https://github.com/foreverallama/matio describes it
(docs/subsystem_data_format.md), with files that MATLAB wrote. So whatever isn't as described
there is an error here, and never a guess.
"""

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int32

MARK = 0xDD000000
"""First number of a reference."""
_VERSIONS = (2, 3, 4)
_HEAD, _REGIONS = 2, 8
"""Numbers before the offsets of the regions, and their count."""
_READ = 4
"""Regions that are read: classes, what is saved in place of objects, objects, the others."""
_PROPERTY = 1
"""The kind of entry whose last number is a cell."""
_FIRST_CELL = 2

Entries = Int32[np.ndarray, "_ 3"]
"""Of one object: name, kind and cell of each property."""


@dataclasses.dataclass(frozen=True, eq=False)
class Store:
    """The properties of a file's objects."""

    names: tuple[str, ...]
    """Names of classes and properties; entries count them from 1."""
    classes: Int32[np.ndarray, "classes 4"]
    """Of each class: the number of its name is the second."""
    objects: Int32[np.ndarray, "objects 6"]
    """Of each object: its class, and which entries are its own, the fourth or the fifth."""
    entries: tuple[Sequence[Entries], Sequence[Entries]]
    """Of objects that save something in their place, and of the others."""
    cells: Sequence[Any]
    """The cells; the last one has what properties are where nothing is saved."""

    @classmethod
    def of(cls, cells: Sequence[Any]) -> "Store":
        """The store of a file.

        Args:
            cells: Its cells, as SciPy gives them.

        Returns:
            The store.

        Raises:
            ValueError: If it isn't laid out as is known.
            IndexError: Likewise.
        """
        if len(cells) <= _FIRST_CELL or np.asarray(cells[0]).dtype != np.uint8:
            raise ValueError("a store of objects without its first cell")
        content = np.asarray(cells[0]).tobytes()
        head = np.frombuffer(content, "<i4", _HEAD + _REGIONS)
        version, count, *places = (int(number) for number in head)
        if version not in _VERSIONS or places != sorted(places) or places[-1] > len(content):
            raise ValueError("a store of objects of an unknown layout")
        regions = [content[a:b] for a, b in itertools.pairwise(places)]
        texts = content[head.nbytes : places[0]].split(b"\0")[:count]
        numbers = [np.frombuffer(region, "<i4") for region in regions[:_READ]]
        return cls(
            tuple(text.decode("utf-8", errors="replace") for text in texts),
            numbers[0].reshape(-1, 4),
            numbers[2].reshape(-1, 6),
            (_blocks(numbers[1]), _blocks(numbers[3])),
            cells,
        )

    def kind(self, reference: Any) -> str:
        """The class of an object.

        Args:
            reference: Its reference.

        Returns:
            Its name.

        Raises:
            ValueError: If this refers to no single object.
            IndexError: If there is no such object.
        """
        return self._name(int(self.classes[self._row(reference)[0], 1]))

    def properties(self, reference: Any) -> Mapping[str, Any]:
        """The properties of an object.

        Args:
            reference: Its reference.

        Returns:
            What each property holds, by its name.

        Raises:
            ValueError: If this refers to no single object.
            IndexError: If there is no such object, or no such cell.
        """
        row = self._row(reference)
        defaults = np.asarray(self.cells[-1], dtype=object).ravel()[row[0]]
        held = {name: defaults[name].ravel()[0] for name in defaults.dtype.names or ()}
        saved, plain = self.entries
        block = saved[row[3]] if row[3] else plain[row[4]]
        for name, kind, cell in block:
            if kind == _PROPERTY:
                if not 0 <= cell < len(self.cells) - _FIRST_CELL:
                    raise IndexError("a property in no cell")
                held[self._name(int(name))] = self.cells[_FIRST_CELL + cell]
        return held

    def _row(self, reference: Any) -> Int32[np.ndarray, " 6"]:
        """What the store says of an object."""
        numbers = reference_of(reference)
        if numbers is None or len(numbers) != 6 or list(numbers[1:4]) != [2, 1, 1]:
            raise ValueError("not one object")
        row = self.objects[numbers[4]]
        if row[0] != numbers[5] or row.min() < 0 or not numbers[4]:
            raise ValueError("an object of another class than its reference says")
        return row

    def _name(self, number: int) -> str:
        if number < 1:
            raise IndexError("a name that isn't there")
        return self.names[number - 1]


def reference_of(value: Any) -> Sequence[int] | None:
    """The numbers of a reference to an object.

    Args:
        value: What SciPy made of the object; within the store it is an array.

    Returns:
        The numbers, None of anything else.
    """
    if getattr(getattr(value, "dtype", None), "names", None) == ("s0", "s1", "s2", "arr"):
        value = np.asarray(value).ravel()[0]["arr"]
    if not isinstance(value, np.ndarray) or value.dtype != np.uint32 or not value.size:
        return None
    numbers = [int(number) for number in value.ravel()]
    return numbers if numbers[0] == MARK else None


def _blocks(numbers: Int32[np.ndarray, " numbers"]) -> list[Entries]:
    """A region's blocks: a count, then three numbers each, filled up to eight bytes."""
    blocks, place = [], 0
    while place < len(numbers):
        count = int(numbers[place])
        end = place + 1 + 3 * count
        if count < 0 or end > len(numbers):
            raise ValueError("a block of properties beyond its region")
        blocks.append(numbers[place + 1 : end].reshape(-1, 3))
        place = end + end % 2
    return blocks
