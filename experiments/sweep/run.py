"""A sweep, unit by unit: what is done is kept, and a stopped one goes on where it was."""

import pathlib
from collections.abc import Callable

import xarray as xr

from experiments.runtime.executors.executor import Executor
from experiments.runtime.executors.here import ThisProcess
from experiments.runtime.installation import installation
from experiments.runtime.job import Job
from experiments.runtime.run import require_all, run
from experiments.runtime.store.store import Distrusted, Store, claimed
from experiments.sweep.axes import Axis
from experiments.sweep.grid import Grid
from experiments.sweep.measure import Measure
from experiments.sweep.netcdf import Records, write_dataset
from experiments.sweep.unit import Sweep, named_inputs
from identification.campaign.quantities import format_quantity
from scdpr_jax.numerics.files import settle
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.parameters import Robot

_SOURCES = ("scdpr-jax", "jax", "jaxlib")


def sweep(
    measure: Measure,
    axes: tuple[Axis, ...],
    robot: Robot,
    out: pathlib.Path,
    *,
    provenance: Provenance = UNKNOWN,
    executor: Executor = ThisProcess(),  # noqa: B008 - it holds nothing
    distrusted: Callable[[Distrusted], None] = lambda each: None,
    progress: Progress = SILENT,
) -> xr.Dataset:
    """Compute a measure over the grid that axes span, and write it as netCDF.

    While it isn't done, results are kept in a folder beside the file: the same call goes on
    where the last one was stopped, at whatever moment, by whatever executor, and ends with the
    same bits. The folder is removed in the end.

    Args:
        measure: What to compute.
        axes: The axes, the last one the fastest.
        robot: The robot; its leaves' dtype is the sweep's.
        out: The netCDF file.
        provenance: Where the robot comes from; of it the file tells all but the day, so that a
            sweep that goes on tomorrow ends with the same bytes.
        executor: Who computes the units.
        distrusted: Told what isn't used of what an earlier call has left.
        progress: Told what is being done and which share of it all is done.

    Returns:
        The dataset as written, read as it is asked for: a dimension for each axis, and those
        of the measure.

    Raises:
        ValueError: If the file exists, parts of another sweep are in its place, or another
            process is at it.
        FloatingPointError: If some points can't be computed.
        OSError: If the place can't be written to.
    """
    folder = out.with_name(f".{out.name}.unfinished")
    if not folder.exists():
        _require_none(out)
    grid = Grid(axes)
    swept = Sweep(measure.of_size(grid.count), grid, robot)
    job = Job("sweep", swept.parcel(), swept.units, executor.installation)
    with claimed(folder, job, named_inputs(swept), distrusted) as store:
        # Who was at it before may have been stopped after all was done.
        if not (out.exists() and store.has_finished(out)):
            if out.exists() and store.is_empty:
                store.remove()
            _require_none(out)
            _fill(swept, store, executor, progress.part(0.0, 0.98))
            progress("writing", 0.98)
            attributes = _attributes(swept, provenance)
            write_dataset(out, swept, Records(swept, store), attributes)
            settle(out.parent)
        store.remove()
    return xr.open_dataset(out, engine="h5netcdf")


def _require_none(out: pathlib.Path) -> None:
    if out.exists():
        raise ValueError(
            f"`--out`: {out} exists already, got a file, expected none. Name another one, or "
            "remove it."
        )


def _fill(swept: Sweep, store: Store, executor: Executor, progress: Progress) -> None:
    """Compute the points that the store hasn't."""
    count = swept.grid.count

    def words(done: int) -> str:
        return f"{min(done * swept.measure.unit, count):,} of {count:,} points"

    def place(number: int) -> str:
        first, last = swept.ends(number)
        return f"points {first:,} to {last - 1:,}"

    failures = run(store, executor, words=words, progress=progress)
    require_all(store, failures, name="parts of the sweep", place=place)


def _attributes(swept: Sweep, provenance: Provenance) -> dict[str, str]:
    """What a dataset says of itself, and of what wasn't swept."""
    units = {variable.name: variable.unit for variable in swept.measure.known}
    versions = installation()
    return {
        "title": f"scdpr sweep {swept.measure.name}",
        "source": ", ".join(f"{name} {versions[name]}" for name in _SOURCES),
        **({"campaign": provenance.campaign} if provenance.campaign else {}),
        **({"logs": provenance.source} if provenance.source else {}),
        **{name: format_quantity(v, units[name]) for name, v in swept.values.items()},
    }
