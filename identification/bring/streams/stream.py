"""A stream of logs that follow each other, cut to its part."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Log
from identification.bring.mapping.document import ColumnTable
from identification.bring.streams.clocks import Clock
from identification.bring.streams.piece import read_piece
from identification.bring.streams.together import Piece, without_blanks
from identification.campaign.faults import Fault
from identification.campaign.tables.columns import Column


@dataclasses.dataclass(frozen=True, eq=False)
class Stream:
    """Columns of one stream of one run."""

    clock: Clock
    """Its instants."""
    columns: Mapping[str, Float64[np.ndarray, " samples"]]
    """Columns by name [SI]."""
    notes: tuple[str, ...]
    """What was done."""


def read_stream(
    logs: Sequence[Log],
    said: Mapping[str, ColumnTable],
    known: Sequence[Column],
    *,
    sparse: bool,
) -> tuple[Stream | None, tuple[Fault, ...]]:
    """A stream of one log, or of several that follow each other.

    Args:
        logs: The logs.
        said: What the mapping says of each column.
        known: The columns that the stream may have.
        sparse: Whether rows without any value are no samples, as between a camera's frames.

    Returns:
        The stream, None if there are faults; and the faults.
    """
    faults = [*_missing(said, known), *_unknown(said, known)]
    if faults:
        return None, tuple(faults)
    pieces: list[Piece] = []
    for log in logs:
        piece, reasons = read_piece(log, said, known)
        faults += reasons
        if piece is not None:
            pieces.append(without_blanks(piece) if sparse else piece)
    if faults:
        return None, tuple(faults)
    names = ", ".join(log.path.name for log in logs)
    begin = f"{names} ({'; '.join(dict.fromkeys(n for log in logs for n in log.notes))})"
    stream = Stream(pieces[0].clock, pieces[0].columns, (begin, *pieces[0].notes))
    for log, piece in zip(logs[1:], pieces[1:], strict=True):
        stream, fault = _continued(stream, piece, log)
        if fault is not None:
            return None, (fault,)
    return stream, ()


def _continued(stream: Stream, piece: Piece, log: Log) -> tuple[Stream, Fault | None]:
    """A stream with the piece that follows it."""
    clock = piece.clock.since(stream.clock.epoch)
    period = stream.clock.period
    last, first = stream.clock.instants[-1], clock.instants[0]
    instants, notes = clock.instants, ()
    if first <= last:
        begins = first - stream.clock.instants[0]
        if not (piece.counted or abs(begins) <= 2 * period or 0 <= first <= 2 * period):
            fault = Fault(
                what="pieces that overlap",
                file=str(log.path),
                got=f"a first time of {first:.6g} s after a last one of {last:.6g} s",
                expected="a piece that follows the one before it, or a clock that begins anew",
                remedy="Order the pieces, or cut them with a run each.",
            )
            return stream, fault
        instants = instants - first + last + period
        notes = (f"the clock begins anew in {log.path.name}: a sample after the last one",)
    columns = {
        name: np.concatenate([values, piece.columns[name]])
        for name, values in stream.columns.items()
    }
    together = np.concatenate([stream.clock.instants, instants])
    notes = tuple(each for each in (*piece.notes, *notes) if each not in stream.notes)
    return Stream(Clock(stream.clock.epoch, together), columns, (*stream.notes, *notes)), None


def cut(stream: Stream, begin: float | None, end: float | None) -> Stream:
    """A part of a stream.

    Args:
        stream: The stream.
        begin: First time that belongs to it [s], None for its begin.
        end: Last time that belongs to it [s], None for its end.

    Returns:
        The part; its clock goes on as it was.
    """
    if begin is None and end is None:
        return stream
    instants = stream.clock.instants
    low = -np.inf if begin is None else begin
    high = np.inf if end is None else end
    inside = (instants >= low) & (instants <= high)
    if inside.all():
        return stream
    note = f"cut to {int(inside.sum())} of {len(inside)} samples"
    return Stream(
        Clock(stream.clock.epoch, instants[inside]),
        {name: values[inside] for name, values in stream.columns.items()},
        (*stream.notes, note),
    )


def _missing(said: Mapping[str, ColumnTable], known: Sequence[Column]) -> list[Fault]:
    faults = []
    for column in known:
        needed = not column.partner or column.partner in said
        if column.name not in said and column.name != "t" and needed:
            fault = Fault(
                what=f"column '{column.name}' is missing",
                got="no such key",
                expected=f'{column.name} = {{ channel = "…", unit = "…" }}',
                remedy="Name its channel.",
            )
            faults.append(fault)
    return faults


def _unknown(said: Mapping[str, ColumnTable], known: Sequence[Column]) -> list[Fault]:
    import difflib

    names = [column.name for column in known]
    faults = []
    for name in said:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1, cutoff=0.0)[0]
            fault = Fault(
                what="a column that the format doesn't know",
                got=repr(name),
                expected=f"one of {', '.join(names)}",
                remedy=f'The nearest is "{near}"; delete the line if that isn\'t meant.',
            )
            faults.append(fault)
    return faults
