"""Writing a campaign in format 1: whole, or not at all."""

import csv
import dataclasses
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import CampaignError
from identification.campaign.quantities import format_quantity
from identification.campaign.read import CAMPAIGN_FILE, RUN_FILE, survey
from identification.campaign.streams import (
    ACCELEROMETER_FILE,
    CAMERA_FILE,
    DRIVE_FIELDS,
    DRIVE_FILE,
)
from identification.campaign.tables.columns import drive_columns
from identification.campaign.tables.document import FORMAT
from identification.campaign.types import (
    AccelerometerStream,
    CameraStream,
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
    Sensors,
    encoder_resolution,
)
from scdpr_jax.numerics.files.scratch import scratch_folder
from scdpr_jax.robot.stated.names import quantity


def write_campaign(campaign: Campaign, path: str | Path) -> None:
    """Write a campaign, so that reading it gives the same data to the last bit.

    It is written beside its place, read back as a check, and then renamed. Runs that were
    skipped when it was read aren't written.

    Args:
        campaign: The campaign.
        path: Its folder; must not exist, or be empty.

    Raises:
        CampaignError: If it couldn't be read back, as with a NaN in a drive stream.
        FileExistsError: If there is something at the path already.
        ValueError: If the name of a run can't be that of a folder.
    """
    target = Path(path)
    _check_free(target)
    for run in campaign.runs:
        check_name(run.name)
    target.parent.mkdir(parents=True, exist_ok=True)
    with scratch_folder(beside=target.parent) as scratch:
        draft = scratch / "draft"
        _write_files(campaign, draft)
        faults = survey(draft).all_faults
        if faults:
            raise CampaignError(target, faults)
        # Takes the place of an empty folder; fails if anything has come into it since.
        draft.replace(target)


def _check_free(target: Path) -> None:
    if target.is_dir() and not any(target.iterdir()):
        return
    if target.exists() or target.is_symlink():
        raise FileExistsError(
            f"campaign {target}: there is something at this path already, expected nothing or "
            "an empty folder. Choose another path, or move it away; nothing is overwritten."
        )


def check_name(name: str) -> None:
    """Refuse the name of a run that can't be that of a folder.

    Args:
        name: The name.

    Raises:
        ValueError: If it can't.
    """
    if not name or name.startswith(".") or any(mark in name for mark in "/\\:\0"):
        raise ValueError(
            f"run {name!r}: the name can't be that of a folder, expected one without "
            'slashes, colons and a leading point. Name it like "0001-torque-step".'
        )


def _write_files(campaign: Campaign, folder: Path) -> None:
    folder.mkdir()
    _write_text(folder / CAMPAIGN_FILE, _campaign_document(campaign))
    write_runs(campaign, folder)


def write_runs(campaign: Campaign, folder: Path) -> None:
    """Write a campaign's runs.

    Args:
        campaign: The campaign.
        folder: The folder that gets one for each run.
    """
    for run in campaign.runs:
        place = folder / run.name
        place.mkdir()
        _write_text(place / RUN_FILE, _run_document(run))
        _write_csv(place / DRIVE_FILE, _drive_columns(run.drive, campaign.counts_per_rev))
        if run.camera is not None:
            _write_csv(place / CAMERA_FILE, _camera_columns(run.camera))
        if run.accelerometer is not None:
            columns = _accelerometer_columns(run.accelerometer)
            _write_csv(place / ACCELEROMETER_FILE, columns)


def _write_text(path: Path, lines: Iterable[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _campaign_document(campaign: Campaign) -> list[str]:
    lines = [f"format = {FORMAT}", f"name = {toml_text(campaign.name)}"]
    if campaign.counts_per_rev is not None:
        lines.append(f"counts_per_rev = {format_quantity(campaign.counts_per_rev, '1')}")
    if campaign.robot:
        lines += ["", "[robot]"]
        lines += [_entry(name, v, quantity(name).unit) for name, v in campaign.robot.items()]
    lines += _section("sensors", campaign.sensors)
    return lines + [
        line
        for run in campaign.runs
        if run.camera_sigma
        for line in ("", *camera_sigma_table(run.name, run.camera_sigma))
    ]


def camera_sigma_table(name: str, sigma: Mapping[str, float]) -> list[str]:
    """The table of `campaign.toml` that states a run's own camera.

    Args:
        name: Name of the run's folder.
        sigma: Standard deviations of its columns [m, rad].

    Returns:
        The table's lines.
    """
    key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_text(name)
    units = dict.fromkeys(sigma, "mm") | {"delta_e": "mrad"}
    entries = [
        f'{column} = "{_thousandths(value)} {units[column]}"' for column, value in sigma.items()
    ]
    return [f"[sensors.runs.{key}]", *entries]


def _run_document(run: Run) -> list[str]:
    lines = [
        f"format = {FORMAT}",
        f"kind = {toml_text(run.kind)}",
        _entry("pretension", run.pretension, "N"),
        f"notes = {toml_text(run.notes)}",
        *_section("initial", run.initial),
        *_section("knock", run.knock),
    ]
    if run.clock_offset is None:
        lines += ["", "[camera]", 'clock_offset = "unknown"']
    elif run.camera is not None or run.clock_offset != 0:
        lines += ["", "[camera]", _entry("clock_offset", run.clock_offset, "s")]
    return lines


def _section(heading: str, record: Sensors | Initial | Knock | None) -> list[str]:
    """The table of a record, whose fields are its keys; none without a record."""
    if record is None:
        return []
    entries = [
        _entry(field.name, getattr(record, field.name), field.metadata["unit"])
        for field in dataclasses.fields(record)
    ]
    return ["", f"[{heading}]", *entries]


def _entry(name: str, value: float, unit: str) -> str:
    return f'{name} = "{format_quantity(value, unit)}"'


def toml_text(text: str) -> str:
    """A text as a basic string of TOML: as JSON writes it, but that DEL is escaped too.

    Args:
        text: The text.

    Returns:
        The string with its quotation marks.
    """
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _write_csv(path: Path, columns: dict[str, list[str]]) -> None:
    with path.open("x", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


def _drive_columns(drive: DriveStream, counts_per_rev: float | None) -> dict[str, list[str]]:
    counts = None if counts_per_rev is None else _whole_counts(drive.angle, counts_per_rev)
    headers = {column.name: column.header for column in drive_columns(counts_per_rev)}
    columns = {}
    for field, names in DRIVE_FIELDS.items():
        numbers, write = getattr(drive, field), repr
        if field == "angle" and counts is not None:
            numbers, write = counts, "{:.0f}".format
            headers |= {name: f"{name} [count]" for name in names}
        if numbers is not None:
            for name, part in zip(names, numbers.T.reshape(len(names), -1), strict=True):
                columns[headers[name]] = _cells(part, write)
    return columns | _extra_columns(drive.extra)


def _camera_columns(camera: CameraStream) -> dict[str, list[str]]:
    x_e, delta_e, q_3, q_4, y_e = camera.position.T
    columns = {
        "t [s]": _cells(camera.time),
        "x_e [mm]": _cells(x_e, _thousandths),
        "y_e [mm]": _cells(y_e, _thousandths),
        "delta_e [rad]": _cells(delta_e),
        "q_3 [mm]": _cells(q_3, _thousandths),
        "q_4 [mm]": _cells(q_4, _thousandths),
    }
    return columns | _extra_columns(camera.extra)


def _accelerometer_columns(stream: AccelerometerStream) -> dict[str, list[str]]:
    axes = {"a_x": stream.along, "a_y": stream.upwards, "a_z": stream.across}
    columns = {f"{n} [m/s^2]": _cells(a) for n, a in axes.items() if a is not None}
    return {"t [s]": _cells(stream.time)} | columns | _extra_columns(stream.extra)


def _extra_columns(extra: dict[str, Shaped[np.ndarray, " rows"]]) -> dict[str, list[str]]:
    return {
        header: _cells(cells) if cells.dtype.kind == "f" else cells.tolist()
        for header, cells in extra.items()
    }


def _whole_counts(
    angle: Float64[np.ndarray, "rows 2"], counts_per_rev: float
) -> Float64[np.ndarray, "rows 2"] | None:
    """The angles in encoder counts, None unless these give the same angles again."""
    resolution = encoder_resolution(counts_per_rev)
    counts = np.rint(angle / resolution)
    return counts if np.array_equal(counts * resolution, angle) else None


def _cells(
    numbers: Float64[np.ndarray, " rows"], write: Callable[[float], str] = repr
) -> list[str]:
    """Numbers as they are written; an empty cell for each NaN."""
    return ["" if math.isnan(number) else write(number) for number in numbers.tolist()]


def _thousandths(number: float) -> str:
    """A number in thousandths, its point moved: a product would round it."""
    return f"{Decimal(repr(number)).scaleb(3):f}"
