"""A sweep, chunk by chunk: what is done is kept, and a stopped one goes on where it was."""

import importlib.metadata
import pathlib
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Array, Float

from experiments.sweep.axes import Axis
from experiments.sweep.grid import Grid
from experiments.sweep.measure import Compute, Measure, Values
from experiments.sweep.netcdf import write_dataset
from experiments.sweep.store import Store, claim
from identification.campaign.quantities import format_quantity
from scdpr_jax.numerics.batches import in_chunks
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import QUANTITIES, replace

_ROBOT = frozenset(quantity.name for quantity in QUANTITIES)


class _Point(eqx.Module):
    """A measure at one point of a sweep."""

    robot: Robot
    fixed: Values
    names: tuple[str, ...] = eqx.field(static=True)
    compute: Compute = eqx.field(static=True)

    @property
    def dtype(self) -> np.dtype:
        """Of what it computes with."""
        return np.dtype(self.robot.frame.width.dtype)

    def __call__(self, values: Float[Array, " axes"]) -> tuple[Array, ...]:
        swept = dict(zip(self.names, values, strict=True))
        robot = replace(self.robot, {n: v for n, v in swept.items() if n in _ROBOT})
        return self.compute(robot, {**self.fixed, **swept})


def sweep(
    measure: Measure,
    axes: tuple[Axis, ...],
    robot: Robot,
    out: pathlib.Path,
    *,
    progress: Progress = SILENT,
) -> xr.Dataset:
    """Compute a measure over the grid that axes span, and write it as netCDF.

    While it isn't done, results are kept in a folder beside the file: the same call goes on
    where the last one was stopped, at whatever moment, and ends with the same bits. The
    folder is removed in the end.

    Args:
        measure: What to compute.
        axes: The axes, the last one the fastest.
        robot: The robot; its leaves' dtype is the sweep's.
        out: The netCDF file.
        progress: Told what is being done and which share of it all is done.

    Returns:
        The dataset as written, read as it is asked for: a dimension for each axis, and those
        of the measure.

    Raises:
        ValueError: If the file exists, or parts of another sweep are in its place.
        OSError: If the place can't be written to.
    """
    if out.exists():
        raise ValueError(
            f"`--out`: {out} exists already, got a file, expected none. Name another one, or "
            "remove it."
        )
    grid = Grid(axes)
    values = {
        v.name: float(v.default(robot)) for v in measure.known if v.name not in grid.names
    }
    point = _Point(
        robot=robot,
        fixed={
            n: jnp.asarray(v, robot.frame.width.dtype)
            for n, v in values.items()
            if n not in _ROBOT
        },
        names=grid.names,
        compute=measure.compute(axes),
    )
    store = claim(
        out.with_name(f".{out.name}.unfinished"),
        _record(measure, point),
        _inputs(measure, grid, robot, values),
    )
    _fill(measure, grid, point, store, progress)
    progress("writing", 1.0)
    write_dataset(out, measure, grid, store, _attributes(measure, values))
    store.remove()
    return xr.open_dataset(out, engine="h5netcdf")


def _fill(
    measure: Measure,
    grid: Grid,
    point: _Point,
    store: Store,
    progress: Progress,
) -> None:
    """Compute the points that the store hasn't."""
    done, size = store.done, measure.chunk * jax.device_count()
    progress("compiling", done / grid.count)
    # From a chunk's beginning on, as in a sweep that is never stopped.
    for first in range(done // size * size, grid.count, size):
        points = grid.points(first, min(first + size, grid.count)).astype(point.dtype)
        records = np.empty(len(points), store.record)
        found = in_chunks(point, points, size=measure.chunk)
        for output, values in zip(measure.outputs, found, strict=True):
            records[output.name] = values
        store.write(first, records)
        last = first + len(points)
        progress(f"{last:,} of {grid.count:,} points", last / grid.count)


def _record(measure: Measure, point: _Point) -> np.dtype:
    """What is kept of a point, from the function's own result."""
    one = jax.ShapeDtypeStruct((len(point.names),), point.dtype)
    found = jax.eval_shape(point, one)
    return np.dtype(
        [
            (o.name, leaf.dtype, leaf.shape)
            for o, leaf in zip(measure.outputs, found, strict=True)
        ]
    )


def _inputs(
    measure: Measure, grid: Grid, robot: Robot, values: dict[str, float]
) -> dict[str, Any]:
    """Everything that the results follow from."""
    return {
        "measure": measure.name,
        "axes": {axis.variable.name: axis.values.tolist() for axis in grid.axes},
        "values": values,
        "robot": [np.asarray(leaf).tolist() for leaf in jax.tree.leaves(robot)],
        "versions": _versions(),
    }


def _attributes(measure: Measure, values: dict[str, float]) -> dict[str, str]:
    """What a dataset says of itself, and of what wasn't swept."""
    units = {variable.name: variable.unit for variable in measure.known}
    return {
        "title": f"scdpr sweep {measure.name}",
        "source": ", ".join(f"{name} {version}" for name, version in _versions().items()),
        **{name: format_quantity(value, units[name]) for name, value in values.items()},
    }


def _versions() -> dict[str, str]:
    return {name: importlib.metadata.version(name) for name in ("scdpr-jax", "jax", "jaxlib")}
