"""Natural frequency and damping over the workspace, from a campaign's knocks."""

import csv
import dataclasses
import io
import math
import pathlib
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from identification.campaign.types import Campaign, Run
from identification.knocks.ring_down import RingDown, ring_down
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.state import X, pose

_MARGIN = 0.05  # s: a frame and a half between the knock and the first sample in use
_CLOCK = 0.1  # s: the same where the camera's clock is unknown by some tens of ms


class _Column(NamedTuple):
    """A column of `frequencies.csv` with numbers in it."""

    field: str
    unit: str
    positive: bool | None
    """True above zero, False not below zero, None any."""

    @property
    def label(self) -> str:
        """Header of the column."""
        return f"{self.field} [{self.unit}]"


_COLUMNS = (
    _Column("x", "m", None),
    _Column("y", "m", None),
    _Column("pretension", "N", True),
    _Column("frequency", "Hz", True),
    _Column("frequency_sigma", "Hz", False),
    _Column("damping_ratio", "1", False),
    _Column("damping_ratio_sigma", "1", False),
)
_RUN = "run"
_SHOWN = 8  # knocks of a map that is printed


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FrequencyMap:
    """Natural frequency and damping at the poses that were knocked, one row a knock."""

    x: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("m", "x_e"))
    """Horizontal position of the end-effector at rest before the knock [m]."""
    y: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("m", "y_e"))
    """Its vertical position [m]."""
    pretension: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("N", "T"))
    """Nominal setting of the cable loop [N]."""
    frequency: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("Hz", "f_n"))
    """Natural frequency of the strongest mode, by the ring-down [Hz]."""
    frequency_sigma: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("Hz"))
    """Its standard error [Hz]."""
    damping_ratio: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("1", r"\zeta"))
    """Damping ratio [1]."""
    damping_ratio_sigma: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("1"))
    """Its standard error [1]."""
    fft_frequency: Float[np.ndarray, " knocks"] = dataclasses.field(metadata=si("Hz"))
    """Natural frequency by the paper's peak picking [Hz], NaN in a map read from a file."""
    residuals_are_noise: Bool[np.ndarray, " knocks"]
    """Whether the ring-down left nothing but the camera's noise; true in a map read from a
    file, whose standard errors have it in them already."""
    runs: tuple[str, ...]
    """Names of the runs."""
    unresolved: tuple[tuple[str, str], ...] = ()
    """Knocks that give no frequency: name of the run, and why."""
    ring_downs: tuple[RingDown, ...] = ()
    """Every knock's ring-down; none in a map read from a file."""

    def __repr__(self) -> str:
        low, high = np.min(self.frequency), np.max(self.frequency)
        lines = [
            f"FrequencyMap of {len(self.runs)} knocks: {low:.3g} to {high:.3g} Hz, "
            f"{len(self.unresolved)} unresolved"
        ]
        lines += [
            f"  {self.frequency[k]:.4g} ± {self.frequency_sigma[k]:.2g} Hz at "
            f"({self.x[k]:.2f} m, {self.y[k]:.2f} m), {self.pretension[k]:g} N: {self.runs[k]}"
            for k in range(min(len(self.runs), _SHOWN))
        ]
        if len(self.runs) > _SHOWN:
            lines.append(f"  and {len(self.runs) - _SHOWN} more")
        return "\n".join(lines)


def frequency_map(campaign: Campaign) -> FrequencyMap:
    """Natural frequencies from all pseudo-impulse runs of a campaign.

    A knock that can't be used is left out and listed in `unresolved` with the reason.

    Args:
        campaign: The campaign; the camera's streams of its pseudo-impulse runs are used.

    Returns:
        The map, in the order of the runs.

    Raises:
        ValueError: If no knock gives a frequency.
    """
    sigma = campaign.sensors.camera_position_sigma
    rows, unresolved = [], []
    knocks = [run for run in campaign.runs if run.kind == "pseudo_impulse"]
    for run in knocks:
        try:
            rows.append(_row(run, noise_sigma=sigma))
        except ValueError as error:
            unresolved.append((run.name, str(error)))
    if not rows:
        reasons = "".join(f"\n  {name}: {reason}" for name, reason in unresolved)
        raise ValueError(
            f"none of {len(knocks)} pseudo_impulse runs gives a frequency, expected one at "
            f"least [Hz]. Knock the end-effector and record it with the camera.{reasons}"
        )
    decays = [decay for _, _, decay, _ in rows]
    return FrequencyMap(
        x=np.array([x for x, _, _, _ in rows]),
        y=np.array([y for _, y, _, _ in rows]),
        pretension=np.array([run.pretension for _, _, _, run in rows], dtype=float),
        frequency=np.array([decay.frequency for decay in decays]),
        frequency_sigma=np.array([decay.frequency_sigma for decay in decays]),
        damping_ratio=np.array([decay.damping_ratio for decay in decays]),
        damping_ratio_sigma=np.array([decay.damping_ratio_sigma for decay in decays]),
        fft_frequency=np.array([decay.fft_frequency for decay in decays]),
        residuals_are_noise=np.array([decay.residuals_are_noise for decay in decays]),
        runs=tuple(run.name for _, _, _, run in rows),
        unresolved=tuple(unresolved),
        ring_downs=tuple(decays),
    )


def _row(run: Run, *, noise_sigma: float) -> tuple[float, float, RingDown, Run]:
    """Pose before the knock [m] and ring-down after it."""
    if run.camera is None:
        raise ValueError(
            "no camera.csv, expected the end-effector's motion after the knock. Record the "
            "knock with the camera."
        )
    if run.knock is None:
        raise ValueError(
            "run.toml has no [knock], expected its start and duration [s]. Write down when "
            'the end-effector was knocked: start = "0.3 s", duration = "30 ms".'
        )
    offset = 0.0 if run.clock_offset is None else run.clock_offset
    margin = _CLOCK if run.clock_offset is None else _MARGIN
    time = np.asarray(run.camera.time)
    position = np.asarray(run.camera.position)
    before = position[time < run.knock.start + offset - margin]
    x, y = (seen[np.isfinite(seen)] for seen in pose(before).T)
    if len(x) == 0 or len(y) == 0:
        raise ValueError(
            f"the camera saw no pose before {run.knock.start + offset - margin:.3g} s, "
            "expected where the end-effector hung before the knock [m]. Start the camera "
            "earlier, or knock later."
        )
    decay = ring_down(
        time,
        position[:, X],
        noise_sigma=noise_sigma,
        after=run.knock.start + run.knock.duration + offset + margin,
    )
    return float(np.median(x)), float(np.median(y)), decay, run


def write_frequencies(frequencies: FrequencyMap, path: pathlib.Path) -> None:
    """Write a map as `frequencies.csv`, whole or not at all.

    Args:
        frequencies: The map; what has no column (`fft_frequency`,
            `residuals_are_noise`, `unresolved` and `ring_downs`) isn't written.
        path: The file, replaced if it exists.
    """
    columns = [getattr(frequencies, column.field).tolist() for column in _COLUMNS]
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow([*(column.label for column in _COLUMNS), _RUN])
    writer.writerows(zip(*columns, frequencies.runs, strict=True))
    write_whole(path, table.getvalue())


def read_frequencies(path: pathlib.Path) -> FrequencyMap:
    """Read a map from `frequencies.csv`.

    Args:
        path: The file.

    Returns:
        The map, without what has no column.

    Raises:
        FileNotFoundError: If there is no such file.
        ValueError: If a column is missing, or a cell isn't a number of its range.
    """
    path = pathlib.Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} isn't UTF-8, expected a CSV text in UTF-8. Save the "
            "table as CSV (UTF-8)."
        ) from error
    rows = [(i, row) for i, row in enumerate(csv.reader(lines), start=1) if any(row)]
    labels = [column.label for column in _COLUMNS]
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    missing = [label for label in (*labels, _RUN) if header.count(label) != 1]
    if missing:
        raise ValueError(
            f"{path}, row 1: got the columns {','.join(header)!r}, expected each of "
            f"{','.join((*labels, _RUN))!r} once; missing or twice: {', '.join(missing)}. "
            "Names and units must be as `scdpr frequencies` writes them."
        )
    if len(rows) < 2:
        raise ValueError(
            f"{path}: no row under the header, expected one natural frequency at least [Hz]. "
            "Write the file again with `scdpr frequencies`."
        )
    for line, row in rows[1:]:
        if len(row) != len(header):
            raise ValueError(
                f"{path}, row {line}: {len(row)} cells, expected {len(header)} as in the "
                "header. Mend the row; the decimal point is '.'."
            )
    numbers = {
        column.field: np.array(
            [
                _cell(path, line, row[header.index(column.label)], column)
                for line, row in rows[1:]
            ]
        )
        for column in _COLUMNS
    }
    return FrequencyMap(
        **numbers,
        fft_frequency=np.full(len(rows) - 1, np.nan),
        residuals_are_noise=np.ones(len(rows) - 1, dtype=bool),
        runs=tuple(row[header.index(_RUN)] for _, row in rows[1:]),
    )


def _cell(path: pathlib.Path, line: int, cell: str, column: _Column) -> float:
    """A cell's number, within the range of its column."""
    expected = {None: "a finite number", True: "a number above 0", False: "a number from 0"}
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    below = column.positive is not None and (value <= 0 if column.positive else value < 0)
    if not math.isfinite(value) or below:
        raise ValueError(
            f"{path}, row {line}, column '{column.label}': got {cell!r}, expected "
            f"{expected[column.positive]} [{column.unit}]. Mend the cell, or leave out the row."
        )
    return value
