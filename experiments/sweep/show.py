"""A sweep's dataset in a terminal: its axes, and the range of every variable."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from rich.console import Console

from experiments.page.console_text import print_table
from experiments.page.number_text import percent, short
from experiments.page.table import Table
from experiments.sweep.grid import blocks
from experiments.sweep.netcdf import BLOCK


def show(console: Console, dataset: xr.Dataset, *, axes: int) -> None:
    """Print what a sweep holds.

    Args:
        console: Where to print it.
        dataset: The dataset, read block by block.
        axes: How many of its leading dimensions are the sweep's axes.
    """
    swept = next(iter(dataset.data_vars.values())).dims[:axes]
    rows = []
    for name in swept:
        values = dataset[name]
        ends = (short(float(values[end]), 4) for end in (0, -1))
        rows.append((str(name), str(values.size), *ends, values.attrs["units"]))
    header = ("axis", "values", "from", "to", "unit")
    print_table(console, Table("", header, tuple(rows), words=(0, 4)))
    console.print()
    header = ("variable", "at", "least", "largest", "unit", "of the points")
    ranges = [row for variable in dataset.data_vars.values() for row in _rows(variable, axes)]
    print_table(console, Table("", header, tuple(ranges), words=(0, 1, 4), spare=((5,),)))


def _rows(variable: xr.DataArray, axes: int) -> Iterator[tuple[str, ...]]:
    """A row for each label of the variable's own dimensions."""
    own = variable.dims[axes:]
    least, largest, share, truths = _ranges(variable, axes)
    for place in np.ndindex(*variable.shape[axes:]):
        at = ", ".join(_at(variable, *pair) for pair in zip(own, place, strict=True))
        if variable.dtype == bool:
            yield str(variable.name), at, "", "", "", percent(truths[place], 4)
            continue
        ends = (short(float(end[place]), 4) for end in (least, largest))
        yield str(variable.name), at, *ends, variable.attrs["units"], percent(share[place], 4)


def _at(variable: xr.DataArray, dimension: str, place: int) -> str:
    label = variable[dimension].values[place]
    return str(label) if isinstance(label, str) else f"{dimension} {label}"


def _ranges(variable: xr.DataArray, axes: int) -> tuple[np.ndarray, ...]:
    """Least and largest finite value, their share, and the mean, for each label."""
    shape, own = variable.shape[:axes], variable.shape[axes:]
    least, largest = np.full(own, np.inf), np.full(own, -np.inf)
    count, total = np.zeros(own), np.zeros(own)
    for block in blocks(shape, BLOCK):
        values = variable[block.place].values.reshape(-1, *own).astype(float)
        finite = np.isfinite(values)
        least = np.minimum(least, values.min(axis=0, where=finite, initial=np.inf))
        largest = np.maximum(largest, values.max(axis=0, where=finite, initial=-np.inf))
        count += finite.sum(axis=0)
        total += values.sum(axis=0, where=finite)
    points = np.prod(shape)
    none = count == 0
    return (
        np.where(none, np.nan, least),
        np.where(none, np.nan, largest),
        count / points,
        total / points,
    )
