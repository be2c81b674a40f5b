"""What a video tells, as `camera.csv` and as a summary."""

import csv
import io
import json
from pathlib import Path

import numpy as np

from identification.vision.poses import COLUMNS
from identification.vision.tracking import Tracked
from scdpr_jax.numerics.files import write_whole

_UNITS = {name: ("rad", 1.0, 7) if name == "delta_e" else ("mm", 1e3, 4) for name in COLUMNS}


def write_camera(path: Path, tracked: Tracked) -> None:
    """Write `camera.csv`.

    Args:
        path: The file, replaced if it exists.
        tracked: What the video tells. Pictures without a time, or not later than the one
            before, have no row; what isn't known is an empty cell.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["t [s]", *(f"{name} [{unit[0]}]" for name, unit in _UNITS.items())])
    last = -np.inf
    for frame, time in enumerate(tracked.clock.frames):
        if not time > last:
            continue
        last = time
        cells = [
            _cell(tracked.poses.values[name][frame] * scale, digits)
            for name, (_, scale, digits) in _UNITS.items()
        ]
        writer.writerow([f"{time:.7f}", *cells])
    write_whole(path, text.getvalue())


def _cell(value: float, digits: int) -> str:
    return "" if np.isnan(value) else f"{value:.{digits}f}"


def write_summary(path: Path, tracked: Tracked) -> None:
    """Write what is to be said of a video as JSON.

    Args:
        path: The file, replaced if it exists.
        tracked: What the video tells.
    """
    write_whole(path, json.dumps(summary(tracked), indent=1, ensure_ascii=False) + "\n")


def summary(tracked: Tracked) -> dict[str, object]:
    """What is to be said of a video.

    Args:
        tracked: What it tells.

    Returns:
        Numbers of pictures, how well lens and marks fit, and standard deviations.
    """
    sigma = tracked.sigma
    return {
        "format": 1,
        "frames": len(tracked.clock.frames),
        "posed": tracked.posed,
        "dropped": tracked.dropped,
        "doubled": int(tracked.doubled.sum()),
        "calibration_rms_px": tracked.marks.view.lens.rms,
        "marks_rms_px": tracked.marks.rms,
        "sigma": _written(sigma.columns),
        "sigma_random": _written(sigma.random),
        "sigma_common": _written(sigma.common),
        "camera_position_sigma": written(sigma.position, "x_e"),
        "camera_angle_sigma": written(sigma.angle, "delta_e"),
        "warnings": list(tracked.warnings),
    }


def rounded(columns: dict[str, float]) -> dict[str, float]:
    """Standard deviations as a file states them.

    Args:
        columns: Of each column [m, rad]; NaN where it is empty.

    Returns:
        Two digits of those of columns that aren't empty [m, rad].
    """
    known = {name: value for name, value in columns.items() if not np.isnan(value)}
    return {name: float(f"{value:.2g}") for name, value in known.items()}


def _written(columns: dict[str, float]) -> dict[str, str | None]:
    return {name: written(columns[name], name) for name in COLUMNS}


def written(value: float, column: str) -> str | None:
    """A standard deviation as people write it.

    Args:
        value: The standard deviation [m, rad].
        column: Its column.

    Returns:
        Two digits and its unit; None where the column is empty.
    """
    if np.isnan(value):
        return None
    unit = "mrad" if column == "delta_e" else "mm"
    return f"{float(f'{1e3 * value:.2g}'):g} {unit}"
