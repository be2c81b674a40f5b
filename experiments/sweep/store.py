"""Results of a sweep on the way: a folder that survives being killed at any moment."""

import json
import pathlib
import shutil
from typing import Any, NamedTuple

import numpy as np

from scdpr_jax.numerics.files import write_whole


class Store(NamedTuple):
    """A file of one record a point, in the points' order, and what they follow from.

    Whole records count, so there is nothing to keep in step with the file; what a kill has
    cut is written anew, from the same inputs with the same bits.
    """

    folder: pathlib.Path
    """Its folder."""
    record: np.dtype
    """What is kept of a point."""

    @property
    def _file(self) -> pathlib.Path:
        return self.folder / "records"

    @property
    def done(self) -> int:
        """Number of points that are kept."""
        return self._file.stat().st_size // self.record.itemsize

    def write(self, first: int, records: np.ndarray) -> None:
        """Keep the records of some points.

        Args:
            first: Index of the first point.
            records: The records.
        """
        with self._file.open("r+b") as file:
            file.seek(first * self.record.itemsize)
            file.write(records.tobytes())

    def read(self, first: int, last: int) -> np.ndarray:
        """The records of some points.

        Args:
            first: Index of the first point.
            last: Index after the last point.

        Returns:
            The records.
        """
        offset = first * self.record.itemsize
        return np.fromfile(self._file, self.record, count=last - first, offset=offset)

    def remove(self) -> None:
        """Remove the folder and all in it."""
        shutil.rmtree(self.folder)


def claim(folder: pathlib.Path, record: np.dtype, inputs: dict[str, Any]) -> Store:
    """A new store, or the one that the same sweep has left.

    Args:
        folder: Its folder.
        record: What is kept of a point.
        inputs: Everything that the results follow from.

    Returns:
        The store.

    Raises:
        ValueError: If another sweep has left its own there.
        OSError: If the place can't be written to.
    """
    manifest = folder / "inputs.json"
    inputs = json.loads(json.dumps({**inputs, "record": str(record)}))
    if manifest.exists() and (began := json.loads(manifest.read_text("utf-8"))) != inputs:
        other = ", ".join(name for name in inputs if began.get(name) != inputs[name])
        raise ValueError(
            f"`--out`: {folder} keeps an unfinished sweep to this file, got another one "
            f"({other} differ), expected the same to go on with. Give the call that began it, "
            "name another file, or remove the folder."
        )
    write_whole(manifest, json.dumps(inputs, indent=1))
    (folder / "records").touch()
    return Store(folder, record)
