"""A sweep's results as a labelled netCDF file, written block by block."""

import pathlib

import h5netcdf
import numpy as np
import xarray as xr

from experiments.runtime.run import result
from experiments.runtime.store.store import Store
from experiments.sweep.grid import Grid, blocks
from experiments.sweep.measure import Measure, Output
from experiments.sweep.unit import Sweep
from scdpr_jax.numerics.files import whole_file

BLOCK = 65536
"""Points in memory at a time."""


class Records:
    """Records of a store, one unit in memory at a time."""

    def __init__(self, swept: Sweep, store: Store) -> None:
        """Reads nothing yet.

        Args:
            swept: The sweep.
            store: Where its results are, every one of them.
        """
        self.dtype, self.folder = swept.record, store.folder
        self._swept, self._store = swept, store
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
            content = result(self._store, number) or b""
            self._number, self._unit = number, np.frombuffer(content, self.dtype)
        return self._unit


def write_dataset(
    path: pathlib.Path, swept: Sweep, records: Records, attributes: dict[str, str]
) -> None:
    """Write a sweep's results, whole or not at all.

    Every axis is a coordinate with its unit; truths are 0 and 1, which xarray reads as
    booleans.

    Args:
        path: The file, replaced if it exists.
        swept: What was computed, and where.
        records: The results.
        attributes: What else is to be known of the whole.
    """
    measure, grid = swept.measure, swept.grid
    # HDF5 makes no file without a name; in the store's folder it is found if it stays behind.
    with whole_file(path, named_in=records.folder) as scratch:
        _labels(measure, grid, attributes).to_netcdf(scratch, engine="h5netcdf")
        with h5netcdf.File(scratch, "a") as file:
            for output in measure.outputs:
                _create(file, output, grid, records.dtype)
            for block in blocks(grid.shape, BLOCK):
                found = records.between(block.first, block.last)
                for output in measure.outputs:
                    variable = file.variables[output.name]
                    shape = np.empty(grid.shape, "V0")[block.place].shape
                    values = found[output.name]
                    values = values.reshape(*shape, *values.shape[1:])
                    variable[block.place] = values.astype(variable.dtype, copy=False)
        records.finish(scratch)


def _labels(measure: Measure, grid: Grid, attributes: dict[str, str]) -> xr.Dataset:
    """The dataset without what was computed."""
    axes = {
        axis.variable.name: (
            (axis.variable.name,),
            axis.values,
            {"units": axis.variable.unit, "long_name": axis.variable.meaning},
        )
        for axis in grid.axes
    }
    own = {name: (name, list(labels)) for name, labels in measure.labels.items()}
    return xr.Dataset(coords={**axes, **own}, attrs=attributes)


def _create(file: h5netcdf.File, output: Output, grid: Grid, record: np.dtype) -> None:
    kind, _ = record[output.name].subdtype or (record[output.name], ())
    truth = kind == np.dtype(bool)
    variable = file.create_variable(
        output.name, (*grid.names, *output.dimensions), np.dtype("i1") if truth else kind
    )
    variable.attrs["long_name"] = output.meaning
    variable.attrs["units"] = output.unit
    if truth:
        # xarray's own mark of a boolean; netCDF has none.
        variable.attrs["dtype"] = "bool"
