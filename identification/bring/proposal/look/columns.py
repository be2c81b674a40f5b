"""Columns of each stream: found in every layout, with units, wraps and lost markers' codes."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Log
from identification.bring.proposal.choice import Choice
from identification.bring.proposal.look import raw
from identification.bring.proposal.look.layouts import Layout, layouts
from identification.bring.proposal.look.roles import OPTIONAL, Role, roles
from identification.bring.proposal.look.signals import Signal, signals
from identification.bring.proposal.look.unnamed import camera_order, unnamed_camera

DRIVE = ("t", "voltage_1", "voltage_2", "alpha_1", "alpha_2", *OPTIONAL[:5])
"""Columns of the drive's stream."""
CAMERA = ("t", "x_e", "y_e", "delta_e", "q_3", "q_4")
"""Columns of the camera's."""
ACCELEROMETER = ("t", "a_x", "a_y", "a_z")
"""Columns of the accelerometer's."""
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "drive": DRIVE,
    "camera": CAMERA,
    "accelerometer": ACCELEROMETER,
}
"""Columns of each stream."""
LEAST: Mapping[str, tuple[tuple[str, ...], int]] = {
    "drive": (DRIVE[1:5], 3),
    "camera": (CAMERA[1:], 3),
    "accelerometer": (ACCELEROMETER[1:], 1),
}
"""Columns that make a stream, and how many of them at least."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class StreamColumns:
    """A stream's columns in the logs."""

    logs: tuple[Path, ...]
    """Logs that have the stream."""
    given: Mapping[str, Role]
    """The columns, by the layout that most logs have."""
    others: Mapping[Path, Mapping[str, Role]]
    """Columns of logs of other layouts."""
    values: Mapping[str, Sequence[np.ndarray]]
    """Numbers of each column in every log of the first layout."""


def stream_columns(logs: Mapping[Path, Log]) -> dict[str, StreamColumns]:
    """The streams of logs, with their columns.

    Args:
        logs: The logs by path.

    Returns:
        The streams that are there, by name.
    """
    found: dict[str, list[tuple[Layout, dict[str, Role]]]] = {}
    for layout in layouts(logs):
        for stream, given in _streams(layout, logs).items():
            found.setdefault(stream, []).append((layout, given))
    made = {}
    for stream, each in found.items():
        # The layout of most logs; of two, the one with the fewer optional columns.
        main, given = max(each, key=lambda pair: (len(pair[0].paths), -len(pair[1])))
        others = {
            path: own for layout, own in each if layout is not main for path in layout.paths
        }
        made[stream] = StreamColumns(
            logs=tuple(path for path in logs if any(path in lay.paths for lay, _ in each)),
            given=given,
            others=others,
            values=_values(main.paths, given, logs),
        )
    return made


def _streams(layout: Layout, logs: Mapping[Path, Log]) -> dict[str, dict[str, Role]]:
    """The streams in one layout's columns."""
    made: dict[str, dict[str, Role]] = {}
    for group in layout.groups:
        given = roles(group)
        unnamed = unnamed_camera(group, given)
        if unnamed:
            columns = [group.signals[k] for k in unnamed]
            values = [_numbers(layout.paths, s, logs) for s in columns]
            names = camera_order(values)
            given = {n: r for n, r in given.items() if n not in CAMERA[1:]}
            for k, name in zip(unnamed, names, strict=True):
                why = "by how it moves with the others; its name doesn't say"
                given[name] = Role(signal=group.signals[k], looks=group.looks[k], why=why)
        for stream, (names, least) in LEAST.items():
            own = {n: r for n, r in given.items() if n in COLUMNS[stream]}
            if sum(name in own for name in names) >= least and stream not in made:
                made[stream] = own
    return made


def _numbers(
    paths: Sequence[Path], signal: Signal, logs: Mapping[Path, Log]
) -> list[np.ndarray]:
    found = []
    for path in paths:
        there = {s.channel: s.values for s in signals(logs[path])}
        if signal.channel in there:
            found.append(there[signal.channel])
    return found


def _values(
    paths: Sequence[Path], given: Mapping[str, Role], logs: Mapping[Path, Log]
) -> dict[str, list[np.ndarray]]:
    there = [{s.channel: s.values for s in signals(logs[path])} for path in paths]
    return {name: [log[role.signal.channel] for log in there] for name, role in given.items()}


def choices(streams: Mapping[str, StreamColumns]) -> dict[str, dict[str, Choice]]:
    """What a mapping would say of each column, by the columns alone.

    Args:
        streams: The streams.

    Returns:
        The choices; a unit that nothing tells is empty, but for the encoders', which the
        camera may tell later.
    """
    made = {}
    for stream, columns in streams.items():
        made[stream] = _stream(stream, columns, COLUMNS[stream])
    return made


def _stream(stream: str, columns: StreamColumns, names: Sequence[str]) -> dict[str, Choice]:
    made = {}
    for name in names:
        role = columns.given.get(name)
        if role is not None:
            made[name] = _choice(stream, name, role, columns)
        elif name not in OPTIONAL and name != "t":
            made[name] = Choice(why=("no column of the log seems to be this",))
        elif name == "t" and not all(r.signal.waveform for r in columns.given.values()):
            made[name] = Choice(why=("no column of the log grows with time: state it",))
    lengths = [name for name in ("x_e", "y_e", "q_3", "q_4") if name in columns.given]
    if stream == "camera" and lengths:
        unit, why = raw.length_unit([columns.values[name] for name in lengths])
        made |= _with_unit(made, lengths, unit, why)
    if stream == "camera" and "delta_e" in columns.given:
        unit, why = raw.rotation_unit(columns.values["delta_e"])
        made |= _with_unit(made, ["delta_e"], unit, why)
    if stream == "drive":
        volts = [name for name in ("voltage_1", "voltage_2") if name in columns.given]
        unit, why = raw.voltage_unit([columns.values[name] for name in volts])
        made |= _with_unit(made, volts, unit, why)
    return made


def _with_unit(
    made: Mapping[str, Choice], names: Sequence[str], unit: str, why: str
) -> dict[str, Choice]:
    return {
        name: made[name].because(f"no unit is stated; {why}", unit=unit)
        for name in names
        if not made[name].unit
    }


def _choice(stream: str, name: str, role: Role, columns: StreamColumns) -> Choice:
    signal = role.signal
    made = Choice(channel=signal.channel, unit=signal.unit, why=(role.why,))
    if name == "t":
        if signal.is_stamp:
            return dataclasses.replace(made, unit="UTC")
        if not signal.unit.strip(" -1"):
            unit, why = raw.time_unit(columns.values["t"], stream)
            made = made.because(f"no unit is stated; {why}", unit=unit)
        return made
    if signal.own_time:
        made = dataclasses.replace(made, own_time=(signal.own_time, "s"))
    if name.startswith("alpha"):
        period = raw.wrap(columns.values[name])
        if period is not None:
            made = made.because(f"it jumps by {period:g}", wraps=period)
    if name in CAMERA[1:]:
        codes = raw.lost_codes(columns.values[name])
        if codes:
            listed = ", ".join(f"{code:g}" for code in codes)
            made = made.because(f"{listed} stands where nothing was seen", lost=codes)
    return made
