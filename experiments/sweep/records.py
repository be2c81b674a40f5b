"""The results of a sweep in their points' order, read as they are asked for."""

import pathlib

import numpy as np

from experiments.runtime.job import Job
from experiments.runtime.run import result
from experiments.runtime.store.store import Store
from experiments.sweep.unit import Sweep


class Records:
    """Records of a store, one unit in memory at a time."""

    def __init__(self, swept: Sweep, job: Job, store: Store) -> None:
        """Reads nothing yet.

        Args:
            swept: The sweep.
            job: The sweep as a job.
            store: Where its results are, every one of them.
        """
        self.dtype, self.folder = swept.record, store.folder
        self._swept, self._job, self._store = swept, job, store
        self._number, self._unit = -1, np.empty(0, self.dtype)

    def between(self, first: int, last: int) -> np.ndarray:
        """The records of some points.

        Args:
            first: Index of the first point.
            last: Index after the last point.

        Returns:
            The records.

        Raises:
            ValueError: If one was damaged since it was written.
        """
        found = np.empty(last - first, self.dtype)
        size = self._swept.measure.unit
        for number in range(first // size, (last - 1) // size + 1):
            begin, end = self._swept.ends(number)
            low, high = max(begin, first), min(end, last)
            found[low - first : high - first] = self._of(number)[low - begin : high - begin]
        return found

    def finish(self, result: pathlib.Path) -> None:
        """Note that all of them are in a file, before that has its name.

        Args:
            result: The file, whole.
        """
        self._store.finish(result)

    def _of(self, number: int) -> np.ndarray:
        if number != self._number:
            content = result(self._job, self._store, number) or b""
            self._number, self._unit = number, np.frombuffer(content, self.dtype)
        return self._unit
