"""What a sweep is asked for: a file that can hold it, and places that a robot can be at."""

import pathlib
import shutil

import numpy as np

from experiments.sweep.axes import Axis
from experiments.sweep.grid import Grid
from experiments.sweep.measure import Measure
from scdpr_jax.robot.parameters import Robot

MANY = 1_000_000_000
"""Points from which on a sweep takes days, which is said."""
_NETCDF = (".nc", ".nc4", ".netcdf", ".h5")
_NUMBER = 8  # bytes


def check_name(out: pathlib.Path) -> None:
    """Refuse a file's name that promises something else than netCDF.

    Args:
        out: The file.

    Raises:
        ValueError: If its suffix isn't netCDF's.
    """
    if out.suffix.lower() not in _NETCDF:
        raise ValueError(
            f"`--out`: got {out}, expected a netCDF file, such as {out.with_suffix('.nc')}: a "
            "sweep has more dimensions than a table. xarray makes one of it: "
            "`xarray.open_dataset(...).to_dataframe().to_csv(...)`."
        )


def check_places(axes: tuple[Axis, ...], robot: Robot) -> None:
    """Refuse an axis of places of which none is in the frame.

    Args:
        axes: The axes.
        robot: The robot.

    Raises:
        ValueError: If no value of `x` or `y` is in the frame.
    """
    swept = {axis.variable.name for axis in axes}
    for name, size in (("x", "frame_width"), ("y", "frame_height")):
        # Of a frame that is swept, too, some may be large enough.
        if size in swept:
            continue
        most = float(robot.frame.width if name == "x" else robot.frame.height)
        for axis in axes:
            values = axis.values
            if axis.variable.name == name and not np.any((values > 0) & (values < most)):
                raise ValueError(
                    f"`--over`: {name} is nowhere in the frame, got {values.min():g} to "
                    f"{values.max():g} m, expected values between 0 and {most:g} m, the "
                    f"`{size}`. Every point would be empty."
                )


def check_room(measure: Measure, axes: tuple[Axis, ...], out: pathlib.Path) -> str:
    """Refuse a sweep for which there is no room, and warn of one that takes days.

    Args:
        measure: What is computed.
        axes: The axes.
        out: The file.

    Returns:
        The warning; empty for none.

    Raises:
        ValueError: If the disk has less room than the results take, twice.
    """
    count = Grid(axes).count
    labels = {name: len(values) for name, values in measure.labels.items()}
    numbers = sum(
        int(np.prod([labels[name] for name in output.dimensions], dtype=float))
        for output in measure.outputs
    )
    size = count * numbers * _NUMBER
    folder = next(each for each in out.absolute().parents if each.exists())
    free = shutil.disk_usage(folder).free
    # What is kept on the way, and the file that is made of it.
    if 2 * size > free:
        raise ValueError(
            f"`--over`: {count:,} points of {numbers} numbers take {2 * size / 1e9:,.1f} GB on "
            f"the way, got {free / 1e9:,.1f} GB free at {folder}. Take fewer points, or name a "
            "larger disk."
        )
    if count < MANY:
        return ""
    return (
        f"{count:,} points take {size / 1e9:,.1f} GB and days; it can be stopped, and goes on "
        "by the same call."
    )
