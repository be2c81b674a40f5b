"""From a mapping to runs: every log opened once, every run's streams made and cut."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Log
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from identification.bring.mapping.document import (
    MappingDocument,
    RunTable,
    StreamTable,
)
from identification.bring.streams.clocks import Clock
from identification.bring.streams.stream import Stream, cut, read_stream
from identification.campaign.faults import Fault
from identification.campaign.quantities import format_quantity
from identification.campaign.streams import POSITIONS, accelerometer_stream, drive_stream
from identification.campaign.tables.columns import ACCELEROMETER, CAMERA, drive_columns
from identification.campaign.types import (
    AccelerometerStream,
    CameraStream,
    DriveStream,
    Initial,
    Knock,
    Run,
)


@dataclasses.dataclass(frozen=True, eq=False)
class Imported:
    """What came of a mapping."""

    runs: tuple[Run, ...]
    """The runs, none where there are faults."""
    faults: tuple[Fault, ...]
    """Everything that is wrong or missing."""


def import_runs(
    document: MappingDocument, *, home: Path, file: str, counts_per_rev: float | None
) -> Imported:
    """The runs of a mapping.

    Args:
        document: The mapping.
        home: The folder that its paths count from.
        file: The mapping itself, for messages.
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], None if unknown.

    Returns:
        The runs, or everything that is wrong.
    """
    faults = list(_mapping_faults(document, file))
    wanted: dict[Path, Dialect] = {}
    for run in document.run:
        for stream, table in _streams(document).items():
            for path in _paths(run, stream, home):
                wanted.setdefault(path, _dialect(table))
    logs, reasons = open_logs(wanted.items())
    made = runs_of(document, logs, home=home, file=file, counts_per_rev=counts_per_rev)
    faults = _told_once((*faults, *reasons, *made.faults))
    return Imported(() if faults else made.runs, faults)


def runs_of(
    document: MappingDocument,
    logs: Mapping[Path, Log],
    *,
    home: Path,
    file: str,
    counts_per_rev: float | None,
) -> Imported:
    """The runs of a mapping, of logs that are open.

    Args:
        document: The mapping.
        logs: The logs by path; runs with others are passed over.
        home: The folder that its paths count from.
        file: The mapping itself, for messages.
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], None if unknown.

    Returns:
        The runs that can be made, and what is wrong with the others.
    """
    runs, faults = [], []
    for run in document.run:
        made, reasons = _run(document, run, logs, home=home, counts=counts_per_rev)
        faults += [_placed(each, run, file) for each in reasons]
        runs += [] if made is None else [made]
    return Imported(tuple(runs), tuple(faults))


def _streams(document: MappingDocument) -> dict[str, StreamTable]:
    return {
        "drive": document.drive,
        "camera": document.camera,
        "accelerometer": document.accelerometer,
    }


def _paths(run: RunTable, stream: str, home: Path) -> list[Path]:
    """A run's logs of a stream."""
    logs = {
        "drive": run.drive_log,
        "camera": run.camera_log,
        "accelerometer": run.accelerometer_log,
    }
    names = logs[stream]
    names = [names] if isinstance(names, str) else names or []
    return [home / name for name in names]


def _dialect(table: StreamTable) -> Dialect:
    separator = {"\\t": "\t", "tab": "\t"}.get(table.separator or "", table.separator)
    return Dialect(
        separator=separator, decimal=table.decimal, encoding=table.encoding, skip=table.skip
    )


def _mapping_faults(document: MappingDocument, file: str) -> list[Fault]:
    """What is missing or there twice in the mapping itself."""
    faults, names = [], set()
    for run in document.run:
        for key, example in (("kind", "torque_step"), ("pretension", "350 N")):
            if getattr(run, key) is None and getattr(document.defaults, key) is None:
                fault = Fault(
                    what="left empty",
                    file=file,
                    key=f"run {run.name!r}.{key}",
                    got="nothing",
                    expected=f'{key} = "{example}"',
                    remedy="State it, or once for all runs in [defaults].",
                )
                faults.append(fault)
        bad = not run.name.strip() or run.name.startswith(".") or set(run.name) & set("/\\:\0")
        if bad or run.name in names or not run.name.isprintable():
            fault = Fault(
                what="a run's name twice" if run.name in names else "no name of a folder",
                file=file,
                key="run.name",
                got=repr(run.name),
                expected='another name for each run, such as "0001-torque-step"',
                remedy="Rename it.",
            )
            faults.append(fault)
        names.add(run.name)
    return faults


def _run(
    document: MappingDocument,
    run: RunTable,
    logs: Mapping[Path, Log],
    *,
    home: Path,
    counts: float | None,
) -> tuple[Run | None, list[Fault]]:
    """A run of its logs, or what is wrong with it."""
    made: dict[str, Stream] = {}
    faults: list[Fault] = []
    known = {
        "drive": drive_columns(counts), "camera": CAMERA, "accelerometer": ACCELEROMETER
    }  # fmt: skip
    overrides = {
        "drive": run.drive_columns,
        "camera": run.camera_columns,
        "accelerometer": run.accelerometer_columns,
    }
    for name, table in _streams(document).items():
        paths = _paths(run, name, home)
        if not paths or any(path not in logs for path in paths):
            continue
        said = {**table.columns, **overrides[name]}
        stream, reasons = read_stream(
            [logs[path] for path in paths], said, known[name], sparse=name == "camera"
        )
        faults += [_in_table(each, name) for each in reasons]
        if stream is not None:
            made[name] = stream
    if faults or "drive" not in made:
        return None, faults
    made = _from_one_zero(made)
    offset = _offset(document, run)
    parts = {
        name: cut(
            stream,
            None if run.begin is None else run.begin + (offset or 0.0) * (name == "camera"),
            None if run.end is None else run.end + (offset or 0.0) * (name == "camera"),
        )
        for name, stream in made.items()
    }
    faults += [
        fault for name, part in parts.items() for fault in _part_faults(name, part, made[name])
    ]
    # What is missing of the run itself has been told already.
    told = _mapping_faults(document.model_copy(update={"run": [run]}), "")
    return (None, faults) if faults or told else (_assembled(document, run, parts, offset), [])


def _from_one_zero(made: Mapping[str, Stream]) -> dict[str, Stream]:
    """Streams on dates counted from the drive's first sample, so that they stay together."""
    drive = made["drive"].clock
    if drive.epoch is None:
        return {name: _bare(stream) for name, stream in made.items()}
    zero = drive.instants[0]
    counted = {}
    for name, stream in made.items():
        clock = stream.clock.since(drive.epoch)
        if stream.clock.epoch is None:
            counted[name] = stream
            continue
        note = "t counts from the drive's first sample"
        counted[name] = Stream(
            Clock(None, clock.instants - zero), stream.columns, (*stream.notes, note)
        )
    return counted


def _bare(stream: Stream) -> Stream:
    """A stream on dates without a drive on dates: from its own first sample."""
    if stream.clock.epoch is None:
        return stream
    instants = stream.clock.instants - stream.clock.instants[0]
    return Stream(
        Clock(None, instants), stream.columns, (*stream.notes, "t counts from its own begin")
    )


def _offset(document: MappingDocument, run: RunTable) -> float | None:
    """Camera time minus drive time [s], None if it is unknown."""
    for table in (run.camera, document.defaults.camera):
        if table is not None:
            return table.clock_offset
    return 0.0


def _part_faults(name: str, part: Stream, whole: Stream) -> list[Fault]:
    instants = whole.clock.instants
    faults = []
    if len(part.clock.instants) < 2:
        fault = Fault(
            what=f"no {name} samples in the part from `from` to `to`",
            got=f"{len(part.clock.instants)} of {len(instants)} samples",
            expected=f"a part of {instants[0]:.6g} to {instants[-1]:.6g} s",
            remedy="Give times on the drive log's own clock.",
        )
        return [fault]
    if name == "camera":
        return []
    for column, values in part.columns.items():
        bad = ~np.isfinite(values)
        if bad.any():
            time = part.clock.instants[int(np.argmax(bad))]
            fault = Fault(
                what=f"an empty cell in the {name}'s log",
                column=column,
                got=f"nothing at t = {time:.6g} s, in {int(bad.sum())} samples",
                expected="a number in every sample",
                remedy="Cut the part out with `from` and `to`, or log that channel again.",
            )
            faults.append(fault)
    return faults


def _assembled(
    document: MappingDocument, run: RunTable, parts: Mapping[str, Stream], offset: float | None
) -> Run:
    default = document.defaults
    initial = run.initial or default.initial
    knock = run.knock or default.knock
    kind = run.kind or default.kind
    pretension = run.pretension if run.pretension is not None else default.pretension
    stated = run.notes if run.notes is not None else default.notes
    told = [f"{name}: {'; '.join(stream.notes)}." for name, stream in parts.items()]
    return Run(
        name=run.name,
        kind=kind,
        pretension=pretension,
        pretension_label=format_quantity(pretension, "N"),
        drive=_drive(parts["drive"]),
        camera=_camera(parts["camera"]) if "camera" in parts else None,
        accelerometer=_accelerometer(parts["accelerometer"])
        if "accelerometer" in parts
        else None,
        notes="\n".join([*filter(None, [stated]), "Imported by scdpr import.", *told]),
        initial=None if initial is None else Initial(**dict(initial)),
        knock=None if knock is None or kind != "pseudo_impulse" else Knock(**dict(knock)),
        clock_offset=offset,
    )


def _drive(part: Stream) -> DriveStream:
    return drive_stream({"t": part.clock.instants, **part.columns}, {})


def _camera(part: Stream) -> CameraStream:
    position = np.stack([part.columns[name] for name in POSITIONS], axis=-1)
    return CameraStream(time=part.clock.instants, position=position)


def _accelerometer(part: Stream) -> AccelerometerStream:
    return accelerometer_stream({"t": part.clock.instants, **part.columns}, {})


def _in_table(fault: Fault, stream: str) -> Fault:
    """A fault of a stream's columns, with the table that says what they are."""
    return fault if fault.file else dataclasses.replace(fault, key=f"{stream}.columns")


def _placed(fault: Fault, run: RunTable, file: str) -> Fault:
    if fault.file or fault.key:
        return dataclasses.replace(fault, file=fault.file or file)
    return dataclasses.replace(fault, file=file, key=f"run {run.name!r}")


def _told_once(faults: Sequence[Fault]) -> tuple[Fault, ...]:
    """Faults without those that are the same in another log: told with the first one."""
    first: dict[Fault, Fault] = {}
    more: dict[Fault, int] = {}
    for fault in faults:
        alike = dataclasses.replace(fault, file="", row=None)
        if fault.key.startswith("run '"):
            alike = dataclasses.replace(alike, key=fault.key.rpartition("'.")[2])
        if alike in first:
            more[alike] += 1
        else:
            first[alike], more[alike] = fault, 0
    return tuple(
        dataclasses.replace(fault, got=f"{fault.got}, and so in {more[alike]} more")
        if more[alike]
        else fault
        for alike, fault in first.items()
    )
