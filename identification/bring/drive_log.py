"""One log as a drive stream, from Python: without a mapping, a run or a campaign."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Log
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from identification.bring.mapping.document import ColumnTable
from identification.bring.streams.piece import find
from identification.bring.streams.stream import Stream, read_stream
from identification.campaign.faults import CampaignError, Fault, listed
from identification.campaign.streams import drive_stream
from identification.campaign.tables.columns import drive_columns
from identification.campaign.tables.header import read_header
from identification.campaign.types import DriveStream


def import_drive_stream(
    path: str | Path, *, columns: Mapping[str, str], counts_per_rev: float | None = None
) -> DriveStream:
    """The controller's stream from a log of any make.

    Args:
        path: The file: TDMS, MAT of version 4 to 7.3, CSV or another text in columns.
        columns: For each header of `drive.csv`, like "voltage_1 [mV]", where its numbers
            are: "group/channel" of a TDMS file; a variable of a MAT file, with points into
            structures and indices, "logs.Rig.alpha[:, 0]"; a header's cell. Without a column
            `t` each channel has the time of its own waveform.
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], for [count].

    Returns:
        The stream in SI units and radians.

    Raises:
        CampaignError: If the file can't be read, or a header, a channel or a number isn't as
            it should be.
    """
    path = Path(path)
    known = drive_columns(counts_per_rev)
    timed = any(name.split(" [")[0] == "t" for name in columns)
    asked = known if timed else tuple(column for column in known if column.name != "t")
    header, faults = read_header(tuple(columns), asked)
    logs, unread = open_logs([(path, Dialect())])
    _refuse(path, (*(dataclasses.replace(f, row=None) for f in faults), *unread))
    log = logs[path]
    said = {
        column.name: ColumnTable(channel=columns[header.cells[place]], unit=header.units[place])
        for place, column in header.columns.items()
    }
    stream, faults = read_stream([log], said, known, sparse=False)
    _refuse(path, faults)
    _refuse(path, _not_finite(stream))
    names = [header.cells[place] for place in header.extra]
    extra = {
        name: _extra(log, name, columns[name], len(stream.clock.instants)) for name in names
    }
    return drive_stream({"t": stream.clock.instants, **stream.columns}, extra)


def _refuse(path: Path, faults: tuple[Fault, ...]) -> None:
    """Raise what is wrong with a file, if anything is."""
    if faults:
        raise CampaignError(path, listed(faults, file=path.name), what="log")


def _not_finite(stream: Stream) -> tuple[Fault, ...]:
    faults = []
    for name, values in stream.columns.items():
        bad = ~np.isfinite(values)
        if bad.any():
            fault = Fault(
                what="not a finite number",
                row=int(np.argmax(bad)) + 1,
                column=name,
                got=f"nothing, the first of {int(bad.sum())}",
                expected="a finite number",
                remedy="Cut the log before it, or log that channel again.",
            )
            faults.append(fault)
    return tuple(faults)


def _extra(log: Log, header: str, text: str, rows: int) -> np.ndarray:
    """A channel that the format doesn't know, as it is."""
    channel, why = find(log, text)
    if channel is None or channel.values.shape != (rows,):
        shape = "no such channel" if channel is None else f"shape {channel.values.shape}"
        fault = Fault(
            what=why or "a channel that can't stand beside the others",
            column=header,
            got=f"{text!r}, {shape}",
            expected=f"{rows} samples",
            remedy="Correct the name in `columns`, or leave it out.",
        )
        _refuse(log.path, (fault,))
    return channel.values
