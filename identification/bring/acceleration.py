"""A raw recording of accelerations, told from a spectrum by its columns."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Log
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from identification.bring.proposal.look.raw import time_unit
from identification.bring.proposal.look.signals import Signal, looks, signals
from identification.bring.proposal.look.words import says, tokens
from identification.bring.streams.stamps import since_1970
from identification.bring.streams.units import UTC, unit_scale
from identification.campaign.faults import CampaignError, Fault
from identification.campaign.tables.columns import ACCELERATION, TIME, Column

_TIME = Column("t", TIME)
_ACCELERATION = Column("a_x", ACCELERATION)
_FREQUENCY = frozenset(["freq", "freqs", "frequency", "frequencies", "hz", "psd", "frequenz"])
"""Words of a spectrum's columns."""


@dataclasses.dataclass(frozen=True, eq=False)
class Acceleration:
    """A recording of accelerations."""

    path: Path
    """The file."""
    time: Float64[np.ndarray, " samples"]
    """Time of each sample [s]."""
    axes: Mapping[str, Float64[np.ndarray, " samples"]]
    """Accelerations by column: in m/s² where the log says their unit, else in its own."""
    notes: tuple[str, ...]
    """How it was read, a sentence each."""


def read_acceleration(path: str | Path) -> Acceleration | None:
    """A raw recording of accelerations.

    Args:
        path: The file: CSV and its relatives, TDMS, MAT.

    Returns:
        The recording, None where the file isn't one: a spectrum, or no columns of numbers.

    Raises:
        CampaignError: If it is a recording whose clock nobody can tell.
    """
    path = Path(path)
    logs, _ = open_logs([(path, Dialect())])
    if path not in logs:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        return _told_recording(logs[path])


def _told_recording(log: Log) -> Acceleration | None:
    columns = signals(log)
    if any(_FREQUENCY & set(tokens(s.words)) for s in columns):
        return None
    time = next((s for s in columns if _is_time(s)), None)
    axes = [s for s in columns if s is not time and _is_acceleration(s)]
    if not axes or (time is None and axes[0].waveform is None):
        return None
    return _recording(log, time, axes)


def _is_time(signal: Signal) -> bool:
    named = says(signal.words, "t") > 0 or signal.is_stamp
    return named and looks([signal.values]).increases


def _is_acceleration(signal: Signal) -> bool:
    if signal.unit.strip(" -1"):
        return unit_scale(_ACCELERATION, signal.unit) is not None
    words = tokens(signal.words)
    return says(signal.words, "accelerometer") > 0 or words in (("x",), ("y",), ("z",))


def _recording(log: Log, time: Signal | None, axes: list[Signal]) -> Acceleration:
    notes = [f"Read as a recording of accelerations: {'; '.join(log.notes)}."]
    if time is None:
        instants = axes[0].waveform.instants(len(axes[0].values))
        notes.append("Its clock is that of its waveforms.")
    else:
        instants = _seconds(log, time, notes)
    made = {}
    for axis in axes:
        scale = unit_scale(_ACCELERATION, axis.unit) if axis.unit.strip(" -1") else None
        made[axis.words] = axis.values if scale is None else scale(axis.values)
    whole = np.all([np.isfinite(values) for values in made.values()], axis=0)
    notes.append(f"Columns of acceleration: {', '.join(map(repr, made))}.")
    made = {name: values[whole] for name, values in made.items()}
    return Acceleration(log.path, instants[whole], made, tuple(notes))


def _seconds(log: Log, time: Signal, notes: list[str]) -> Float64[np.ndarray, " samples"]:
    if time.is_stamp:
        return time.values
    unit, why = time.unit, ""
    if unit == UTC:
        unit = since_1970(time.values)
    if not unit.strip(" -1"):
        unit, why = time_unit([time.values], "accelerometer")
        notes.append(f"Column {time.words!r} is taken as time in {unit}: {why}.")
    scale = unit_scale(_TIME, unit) if unit else None
    if scale is None:
        fault = Fault(
            what="a recording of accelerations without a clock",
            file=str(log.path),
            column=time.words,
            got=f"unit {unit!r}; {why}" if why else f"unit {unit!r}",
            expected="a unit of time in the header: `time [s]`",
            remedy="Write the unit into the header.",
        )
        raise CampaignError(log.path, (fault,), what="recording")
    return scale(time.values - time.values[0])
