"""A sweep, part by part: what is done is kept, and a stopped one goes on where it was."""

import importlib.metadata
import json
import pathlib
import shutil
from collections.abc import Callable, Iterator

import equinox as eqx
import jax
import numpy as np
import xarray as xr
from jaxtyping import Array, Float

from experiments.sweep.axes import Axis, count, rows
from experiments.sweep.measures import MEASURES, Measure, Results, Values, defaults
from scdpr_jax.batches import chunks
from scdpr_jax.files import whole_file, write_whole
from scdpr_jax.parameters import QUANTITIES, Robot, replace

_MANIFEST = "manifest.json"


class _Point(eqx.Module):
    """A measure at one point of a sweep."""

    robot: Robot
    fixed: dict[str, float] = eqx.field(static=True)
    names: tuple[str, ...] = eqx.field(static=True)
    compute: Callable[[Robot, Values], Results] = eqx.field(static=True)

    def __call__(self, values: Float[Array, " axes"]) -> Results:
        swept = dict(zip(self.names, values, strict=True))
        known = {quantity.name for quantity in QUANTITIES}
        robot = replace(self.robot, {n: v for n, v in swept.items() if n in known})
        fixed = {name: jax.numpy.asarray(v, values.dtype) for name, v in self.fixed.items()}
        return self.compute(robot, fixed | swept)


def sweep(
    measure_name: str,
    axes: tuple[Axis, ...],
    robot: Robot,
    out: pathlib.Path,
    *,
    progress: Callable[[str, float], None] = lambda doing, share: None,
) -> xr.Dataset:
    """Compute a measure over the grid that axes span, and write it as netCDF.

    Parts of the grid are kept in a folder beside the file while it isn't done: the same
    call goes on where the last one was stopped, at whatever moment, and ends with the same
    bits. The folder is removed in the end.

    Args:
        measure_name: Which of `MEASURES`.
        axes: The axes, the last one the fastest.
        robot: The robot; its leaves' dtype is the sweep's.
        out: The netCDF file.
        progress: Told what is being done and which share of it all is done.

    Returns:
        The dataset as written: one dimension for each axis, and those of the measure.

    Raises:
        ValueError: If the file exists, or parts of another sweep are in its place.
        OSError: If the place can't be written to.
    """
    measure = MEASURES[measure_name]
    folder = out.with_name(f".{out.name}.parts")
    if out.exists():
        raise ValueError(
            f"`--out`: {out} exists already, got a file, expected none. Name another one, or "
            "remove it."
        )
    manifest = _manifest(measure_name, measure, axes, robot)
    _claim(folder, manifest, out)

    total = count(axes)
    dtype = np.asarray(robot.frame.width).dtype
    point = _Point(
        robot=robot,
        fixed=_fixed(measure, axes, robot),
        names=tuple(axis.variable.name for axis in axes),
        compute=measure.function(axes),
    )
    starts = range(0, total, measure.part)
    for first in starts:
        part = folder / f"{first:012d}.npz"
        last = min(first + measure.part, total)
        if not part.exists():
            found = []
            for chunk in chunks(
                point, rows(axes, first, last).astype(dtype), size=measure.chunk
            ):
                found.append(chunk)
                done = first + sum(len(results[0]) for results in found)
                progress(f"{done:,} of {total:,} points", done / total)
            named = {
                output.name: np.concatenate(leaves)
                for output, leaves in zip(
                    measure.outputs, zip(*found, strict=True), strict=True
                )
            }
            with whole_file(part) as scratch, scratch.open("wb") as file:
                np.savez(file, **named)
        progress(f"{last:,} of {total:,} points", last / total)

    parts = (folder / f"{first:012d}.npz" for first in starts)
    dataset = _dataset(measure, axes, manifest, parts)
    with whole_file(out) as scratch:
        dataset.to_netcdf(scratch, engine="h5netcdf")
    shutil.rmtree(folder)
    return dataset


def _fixed(measure: Measure, axes: tuple[Axis, ...], robot: Robot) -> dict[str, float]:
    """The measure's own variables that aren't swept."""
    swept = {axis.variable.name for axis in axes}
    own = {variable.name for variable in measure.variables} - swept
    return {n: v for n, v in defaults(measure, robot).items() if n in own}


def _manifest(name: str, measure: Measure, axes: tuple[Axis, ...], robot: Robot) -> str:
    """Everything that the results follow from."""
    values = defaults(measure, robot)
    for axis in axes:
        values.pop(axis.variable.name)
    return json.dumps(
        {
            "format": 1,
            "measure": name,
            "axes": {axis.variable.name: axis.values.tolist() for axis in axes},
            "values": values,
            "robot": [np.asarray(leaf).tolist() for leaf in jax.tree.leaves(robot)],
            "dtype": str(np.asarray(robot.frame.width).dtype),
            "part": measure.part,
            "versions": {p: importlib.metadata.version(p) for p in ("scdpr-jax", "jax")},
        },
        indent=1,
    )


def _claim(folder: pathlib.Path, manifest: str, out: pathlib.Path) -> None:
    """Make the folder of the parts, or find in it what this same sweep has left there."""
    place = folder / _MANIFEST
    if place.exists() and place.read_text(encoding="utf-8") != manifest:
        raise ValueError(
            f"`--out`: {folder} has parts of another sweep to {out}, got other axes, another "
            "robot or version, expected the same. Give the call that began it, name another "
            "file, or remove the folder."
        )
    write_whole(place, manifest)


def _dataset(
    measure: Measure, axes: tuple[Axis, ...], manifest: str, parts: Iterator[pathlib.Path]
) -> xr.Dataset:
    """The parts put together and labelled."""
    total = count(axes)
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.variable.name for axis in axes)
    whole: dict[str, np.ndarray] = {}
    first = 0
    for path in parts:
        with np.load(path, allow_pickle=False) as part:
            last = first
            for output in measure.outputs:
                rows_ = part[output.name]
                target = whole.setdefault(
                    output.name, np.empty((total, *rows_.shape[1:]), rows_.dtype)
                )
                last = first + len(rows_)
                target[first:last] = rows_
        first = last
    written = json.loads(manifest)
    dataset = xr.Dataset(
        {
            o.name: (
                (*names, *o.dimensions),
                whole[o.name].reshape(*shape, *whole[o.name].shape[1:]),
                {"units": o.unit, "long_name": o.meaning},
            )
            for o in measure.outputs
        },
        coords={
            **{
                a.variable.name: (
                    (a.variable.name,),
                    a.values,
                    {"units": a.variable.unit, "long_name": a.variable.meaning},
                )
                for a in axes
            },
            **{name: (name, list(labels)) for name, labels in measure.coordinates.items()},
        },
        attrs={
            "title": f"scdpr sweep {written['measure']}",
            "fixed_values": json.dumps(written["values"]),
            "source": " ".join(f"{p} {v}" for p, v in written["versions"].items()),
        },
    )
    return dataset
