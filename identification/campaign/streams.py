"""The two streams of a run, from their tables."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import Fault
from identification.campaign.tables.columns import CAMERA, drive_columns
from identification.campaign.tables.table import read_table
from identification.campaign.types import CameraStream, DriveStream

DRIVE_FILE = "drive.csv"
"""Name of the controller's stream."""
CAMERA_FILE = "camera.csv"
"""Name of the vision system's stream."""


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
    table, faults = read_table(
        folder / DRIVE_FILE,
        drive_columns(counts_per_rev),
        file=f"{folder.name}/{DRIVE_FILE}",
        may_be_empty=False,
    )
    if table is None:
        return None, faults
    return drive_stream(table.values, table.extra), ()


def read_camera(folder: Path) -> tuple[CameraStream | None, tuple[Fault, ...]]:
    """The vision system's stream of a run.

    Args:
        folder: The run's folder.

    Returns:
        The stream, None if there is no such file or there are faults; and the faults.
    """
    path = folder / CAMERA_FILE
    if not path.exists():
        return None, ()
    table, faults = read_table(
        path, CAMERA, file=f"{folder.name}/{CAMERA_FILE}", may_be_empty=True
    )
    if table is None:
        return None, faults
    order = ("x_e", "delta_e", "q_3", "q_4", "y_e")
    position = np.stack([table.values[name] for name in order], axis=-1)
    stream = CameraStream(time=table.values["t"], position=position, extra=table.extra)
    return stream, ()


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

    def pair(first: str, second: str) -> Float64[np.ndarray, "rows 2"] | None:
        if first not in values:
            return None
        return np.stack([values[first], values[second]], axis=-1)

    return DriveStream(
        time=values["t"],
        voltage=pair("voltage_1", "voltage_2"),
        angle=pair("alpha_1", "alpha_2"),
        current=pair("current_1", "current_2"),
        tension=values.get("tension"),
        reference=pair("x_ref", "y_ref"),
        extra=dict(extra),
    )
