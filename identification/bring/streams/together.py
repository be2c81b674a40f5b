"""Columns on clocks of their own, at one stream's instants."""

import dataclasses
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Log
from identification.bring.streams.clocks import Clock, carried_over, covered
from identification.bring.streams.numbers import Numbers
from identification.campaign.faults import Fault

HELD = ("voltage_1", "voltage_2")
"""Columns that hold until the next sample."""


@dataclasses.dataclass(frozen=True, eq=False)
class Piece:
    """A log's columns on one clock."""

    clock: Clock
    """The instants."""
    columns: Mapping[str, Float64[np.ndarray, " samples"]]
    """Columns by name [SI]."""
    notes: tuple[str, ...]
    """What was done."""
    counted: bool
    """Whether the instants are samples over a rate, and begin anew in every log."""


def together(
    log: Log,
    clock: Clock,
    note: str,
    made: Mapping[str, Numbers],
    clocks: Mapping[str, Clock],
    *,
    counted: bool,
) -> tuple[Piece | None, tuple[Fault, ...]]:
    """Columns at a stream's instants, as far as every channel has samples.

    Args:
        log: The log.
        clock: The stream's clock.
        note: Where that comes from.
        made: The columns' numbers.
        clocks: Clocks of those that have their own.
        counted: Whether the stream's clock counts samples at a stated rate.

    Returns:
        The columns, None if there is a fault; and the faults.
    """
    apart = [
        name for name, own in clocks.items() if (own.epoch is None) != (clock.epoch is None)
    ]
    if apart:
        return None, (_apart(log, apart),)
    own = {name: each.since(clock.epoch) for name, each in clocks.items()}
    bounds = [covered(clock.instants, each) for each in own.values()]
    first = max((begin for begin, _ in bounds), default=-np.inf)
    last = min((end for _, end in bounds), default=np.inf)
    inside = (clock.instants >= first) & (clock.instants <= last)
    if inside.sum() < 2:
        return None, (_never(log, first, last),)
    instants = clock.instants[inside]
    notes = [*(text for each in made.values() for text in each.notes), note]
    columns = {}
    for name, each in made.items():
        if name not in own:
            columns[name] = each.values[inside]
            continue
        held = name in HELD
        columns[name], how = carried_over(each.values, own[name], instants, held=held)
        notes += [f"{name}: {how}"] if how else []
    if not inside.all():
        left = int((~inside).sum())
        notes.append(f"{left} of {len(inside)} samples left out, which not every channel has")
    return Piece(Clock(clock.epoch, instants), columns, tuple(notes), counted), ()


def without_blanks(piece: Piece) -> Piece:
    """A camera's columns without the rows of a faster log that are no frame of their own.

    Args:
        piece: The columns.

    Returns:
        The same, or the rows with frames where most have none.
    """
    rows = np.stack(list(piece.columns.values()))
    blank = np.isnan(rows).all(axis=0)
    what = "rows without any frame"
    if blank.mean() <= 0.5:
        # A faster logger repeats a frame until the next one comes.
        same = (rows[:, 1:] == rows[:, :-1]) | (np.isnan(rows[:, 1:]) & np.isnan(rows[:, :-1]))
        blank |= np.r_[False, same.all(axis=0)]
        what = "rows that repeat a frame"
    if blank.mean() <= 0.5 or (~blank).sum() < 2:
        return piece
    kept = {name: values[~blank] for name, values in piece.columns.items()}
    return dataclasses.replace(
        piece,
        clock=Clock(piece.clock.epoch, piece.clock.instants[~blank]),
        columns=kept,
        notes=(*piece.notes, f"{int(blank.sum())} {what} left out"),
    )


def _apart(log: Log, names: list[str]) -> Fault:
    return Fault(
        what="clocks that can't be compared",
        file=str(log.path),
        column=names[0],
        got="dates on one and seconds without a date on the other",
        expected="dates on both, or on neither",
        remedy='State the other clock: t = { channel = "…", unit = "s" } in that column.',
    )


def _never(log: Log, first: float, last: float) -> Fault:
    return Fault(
        what="channels that were never logged together",
        file=str(log.path),
        got=f"samples of all from {first:.6g} to {last:.6g} s",
        expected="two common samples at least",
        remedy="Check where the channels start, or name others.",
    )
