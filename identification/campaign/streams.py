"""The two streams of a run, from their tables."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import Fault
from identification.campaign.tables.columns import ACCELEROMETER, CAMERA, Column, drive_columns
from identification.campaign.tables.table import read_table
from identification.campaign.types import AccelerometerStream, CameraStream, DriveStream

Stream = TypeVar("Stream", DriveStream, CameraStream, AccelerometerStream)

DRIVE_FILE = "drive.csv"
"""Name of the controller's stream."""
EPOCH = 1e8
"""Times from which on a clock counts from 1970 and not from a run's begin: three years [s]."""
CAMERA_FILE = "camera.csv"
"""Name of the vision system's stream."""

ACCELEROMETER_FILE = "accelerometer.csv"
"""Name of the accelerometer's stream."""

DRIVE_FIELDS: dict[str, tuple[str, ...]] = {
    "time": ("t",),
    "voltage": ("voltage_1", "voltage_2"),
    "angle": ("alpha_1", "alpha_2"),
    "current": ("current_1", "current_2"),
    "tension": ("tension",),
    "reference": ("x_ref", "y_ref"),
}
"""Which columns of `drive.csv` each field of a `DriveStream` is made of."""

POSITIONS = ("x_e", "delta_e", "q_3", "q_4", "y_e")
"""Columns of `camera.csv` that a `CameraStream`'s positions are made of."""


def read_drive(
    folder: Path, *, counts_per_rev: float | None
) -> tuple[DriveStream | None, tuple[Fault, ...]]:
    """The controller's stream of a run.

    Args:
        folder: The run's folder.
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], None if unknown.

    Returns:
        The stream, None if there are faults; and the faults.
    """
    return _read(folder / DRIVE_FILE, drive_columns(counts_per_rev), drive_stream)


def read_camera(folder: Path) -> tuple[CameraStream | None, tuple[Fault, ...]]:
    """The vision system's stream of a run.

    Args:
        folder: The run's folder.

    Returns:
        The stream, None if there is no such file or there are faults; and the faults.
    """
    path = folder / CAMERA_FILE
    if not os.path.lexists(path):
        return None, ()
    return _read(path, CAMERA, camera_stream, may_be_empty=True)


def read_accelerometer(
    folder: Path,
) -> tuple[AccelerometerStream | None, tuple[Fault, ...]]:
    """The accelerometer's stream of a run.

    Args:
        folder: The run's folder.

    Returns:
        The stream, None if there is no such file or there are faults; and the faults.
    """
    path = folder / ACCELEROMETER_FILE
    if not os.path.lexists(path):
        return None, ()
    return _read(path, ACCELEROMETER, accelerometer_stream)


def _read(
    path: Path,
    columns: tuple[Column, ...],
    stream: Callable[..., Stream],
    *,
    may_be_empty: bool = False,
) -> tuple[Stream | None, tuple[Fault, ...]]:
    """A stream by its table, None if that has faults; and the faults."""
    file = f"{path.parent.name}/{path.name}"
    table, faults = read_table(path, columns, file=file, may_be_empty=may_be_empty)
    return (None if table is None else stream(table.values, table.extra)), faults


def camera_stream(
    values: Mapping[str, Float64[np.ndarray, " rows"]],
    extra: Mapping[str, Shaped[np.ndarray, " rows"]],
) -> CameraStream:
    """The vision system's stream of its columns.

    Args:
        values: Columns by their names in the format [SI].
        extra: Other columns by header.

    Returns:
        The stream.
    """
    position = np.stack([values[name] for name in POSITIONS], axis=-1)
    return CameraStream(time=values["t"], position=position, extra=dict(extra))


def accelerometer_stream(
    values: Mapping[str, Float64[np.ndarray, " rows"]],
    extra: Mapping[str, Shaped[np.ndarray, " rows"]],
) -> AccelerometerStream:
    """The accelerometer's stream of its columns.

    Args:
        values: Columns by their names in the format [SI].
        extra: Other columns by header.

    Returns:
        The stream.
    """
    return AccelerometerStream(
        time=values["t"],
        along=values["a_x"],
        upwards=values.get("a_y"),
        across=values.get("a_z"),
        extra=dict(extra),
    )


def drive_stream(
    values: Mapping[str, Float64[np.ndarray, " rows"]],
    extra: Mapping[str, Shaped[np.ndarray, " rows"]],
) -> DriveStream:
    """The controller's stream of its columns.

    Args:
        values: Columns by their names in the format [SI].
        extra: Other columns by header.

    Returns:
        The stream; what is optional and not there is None.
    """
    fields = {
        field: np.stack([values[name] for name in names], axis=-1)
        if len(names) > 1
        else values[names[0]]
        for field, names in DRIVE_FIELDS.items()
        if names[0] in values
    }
    return DriveStream(**fields, extra=dict(extra))
