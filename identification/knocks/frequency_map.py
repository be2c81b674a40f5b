"""Natural frequency and damping over the workspace, from a campaign's knocks."""

import csv
import dataclasses
import io
import pathlib
from typing import Annotated

import numpy as np
import pydantic
from jaxtyping import Bool, Float

from identification.campaign.types import Campaign, Run
from identification.knocks.accelerometer import accelerometer_ring_down, joined
from identification.knocks.ring_down import RingDown, ring_down
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.files.given import read_given_rows
from scdpr_jax.numerics.files.harmless import cell, represented, text_of_cell
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.state import X, pose

_MARGIN = 0.05  # s: a frame and a half between the knock and the first sample in use
_CLOCK = 0.1  # s: the same where the camera's clock is unknown by some tens of ms


Positive = Annotated[float, pydantic.Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, pydantic.Field(ge=0, allow_inf_nan=False)]


class _Row(pydantic.BaseModel):
    """A row of `frequencies.csv` under its headers."""

    x: pydantic.FiniteFloat = pydantic.Field(alias="x [m]")
    y: pydantic.FiniteFloat = pydantic.Field(alias="y [m]")
    pretension: Positive = pydantic.Field(alias="pretension [N]")
    frequency: Positive = pydantic.Field(alias="frequency [Hz]")
    frequency_sigma: NotNegative = pydantic.Field(alias="frequency_sigma [Hz]")
    damping_ratio: NotNegative = pydantic.Field(alias="damping_ratio [1]")
    damping_ratio_sigma: NotNegative = pydantic.Field(alias="damping_ratio_sigma [1]")
    run: str


_LABELS = {name: field.alias or name for name, field in _Row.model_fields.items()}
"""Headers of the columns by the names of the rows' fields."""
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
        campaign: The campaign; of its pseudo-impulse runs the camera's and the accelerometer's
            streams are used.

    Returns:
        The map, in the order of the runs.

    Raises:
        ValueError: If no knock gives a frequency.
    """
    usable, unresolved = [], []
    knocks = [run for run in campaign.runs if run.kind == "pseudo_impulse"]
    for run in knocks:
        sigma = float(campaign.sensors.of_camera(run)[0])
        try:
            usable.append((run, *_pose_and_decay(run, noise_sigma=sigma)))
        except ValueError as error:
            unresolved.append((run.name, str(error)))
    if not usable:
        reasons = "".join(f"\n  {name}: {reason}" for name, reason in unresolved)
        raise ValueError(
            f"none of {len(knocks)} pseudo_impulse runs gives a frequency, expected one at "
            "least [Hz]. Knock the end-effector and record it with the camera or an "
            f"accelerometer.{reasons}"
        )
    runs, poses, decays = zip(*usable, strict=True)
    x, y = np.array(poses).T
    # What a map and a ring-down both have is a column of the map.
    both = {f.name for f in dataclasses.fields(FrequencyMap)}
    both &= {f.name for f in dataclasses.fields(RingDown)}
    return FrequencyMap(
        x=x,
        y=y,
        pretension=np.array([run.pretension for run in runs], dtype=float),
        **{name: np.array([getattr(decay, name) for decay in decays]) for name in both},
        runs=tuple(run.name for run in runs),
        unresolved=tuple(unresolved),
        ring_downs=decays,
    )


def _pose_and_decay(run: Run, *, noise_sigma: float) -> tuple[tuple[float, float], RingDown]:
    """Pose before the knock [m] and ring-down after it, by every sensor that there is."""
    if run.accelerometer is None:
        return _by_camera(run, noise_sigma=noise_sigma)
    knock = run.knock
    stated = None if knock is None else (knock.start, knock.start + knock.duration)
    decay = accelerometer_ring_down(run.accelerometer, stated=stated)
    if run.camera is None:
        if run.initial is None:
            raise ValueError(
                "neither camera.csv nor [initial], expected where the end-effector hung "
                'before the knock [m]. Write [initial] with x_e = "0.3 m" and y_e in run.toml.'
            )
        return (run.initial.x_e, run.initial.y_e), decay
    if knock is None:
        return _pose(run, before=float(decay.window[0]) - _CLOCK), decay
    place, filmed = _by_camera(run, noise_sigma=noise_sigma)
    return place, joined(filmed, decay)


def _pose(run: Run, *, before: float) -> tuple[float, float]:
    """Where the camera saw the end-effector up to some time on its clock [m]."""
    time = np.asarray(run.camera.time)
    x, y = (seen[np.isfinite(seen)] for seen in pose(run.camera.position[time < before]).T)
    if len(x) == 0 or len(y) == 0:
        raise ValueError(
            f"the camera saw no pose before {before:.3g} s, expected where the end-effector "
            "hung before the knock [m]. Start the camera earlier, or knock later."
        )
    return float(np.median(x)), float(np.median(y))


def _by_camera(run: Run, *, noise_sigma: float) -> tuple[tuple[float, float], RingDown]:
    """The same by the camera alone."""
    if run.camera is None:
        raise ValueError(
            "no camera.csv and no accelerometer.csv, expected the end-effector's motion "
            "after the knock. Record the knock with the camera, or with an accelerometer."
        )
    if run.knock is None:
        raise ValueError(
            "run.toml has no [knock], expected its start and duration [s]. Write down when "
            'the end-effector was knocked: start = "0.3 s", duration = "30 ms".'
        )
    offset = 0.0 if run.clock_offset is None else run.clock_offset
    margin = _CLOCK if run.clock_offset is None else _MARGIN
    place = _pose(run, before=run.knock.start + offset - margin)
    decay = ring_down(
        np.asarray(run.camera.time),
        np.asarray(run.camera.position)[:, X],
        noise_sigma=noise_sigma,
        after=run.knock.start + run.knock.duration + offset + margin,
    )
    return place, decay


def write_frequencies(
    frequencies: FrequencyMap, path: pathlib.Path, *, provenance: Provenance = UNKNOWN
) -> None:
    """Write a map as `frequencies.csv`, whole or not at all.

    Args:
        frequencies: The map; what has no column (`fft_frequency`,
            `residuals_are_noise`, `unresolved` and `ring_downs`) isn't written.
        path: The file, replaced if it exists.
        provenance: Where it comes from, in columns of its own behind the others.
    """
    numbers = [getattr(frequencies, name).tolist() for name in _LABELS if name != "run"]
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    told = {} if provenance == UNKNOWN else provenance.model_dump()
    writer.writerow((*_LABELS.values(), *told))
    for row in zip(*numbers, map(cell, frequencies.runs), strict=True):
        writer.writerow((*row, *map(cell, told.values())))
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
    rows = read_given_rows(path)
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    missing = [label for label in _LABELS.values() if header.count(label) != 1]
    if missing:
        raise ValueError(
            f"{path}, row 1: got the columns {represented(','.join(header))}, expected each of "
            f"{','.join(_LABELS.values())!r} once; missing or twice: {', '.join(missing)}. "
            "Names and units must be as `scdpr frequencies` writes them."
        )
    if len(rows) < 2:
        raise ValueError(
            f"{path}: no row under the header, expected one natural frequency at least [Hz]. "
            "Write the file again with `scdpr frequencies`."
        )
    knocks = [_row(path, line, header, cells) for line, cells in rows[1:]]
    numbers = [name for name in _LABELS if name != "run"]
    return FrequencyMap(
        **{name: np.array([getattr(knock, name) for knock in knocks]) for name in numbers},
        runs=tuple(text_of_cell(knock.run) for knock in knocks),
        fft_frequency=np.full(len(knocks), np.nan),
        residuals_are_noise=np.ones(len(knocks), dtype=bool),
    )


def _row(path: pathlib.Path, line: int, header: list[str], cells: list[str]) -> _Row:
    """A row's numbers, each within the range of its column."""
    if len(cells) != len(header):
        raise ValueError(
            f"{path}, row {line}: {len(cells)} cells, expected {len(header)} as in the "
            "header. Mend the row; the decimal point is '.'."
        )
    try:
        return _Row.model_validate(dict(zip(header, cells, strict=True)))
    except pydantic.ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise ValueError(
            f"{path}, row {line}, column '{first['loc'][0]}': got "
            f"{represented(first['input'])}; {first['msg'].lower()}. Mend the cell, "
            "or leave out the row."
        ) from None
