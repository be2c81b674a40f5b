"""One log's columns on one clock."""

import dataclasses
import difflib
import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Channel, Log
from identification.bring.files.csv.log import bare
from identification.bring.files.mat.path import channel_of
from identification.bring.mapping.document import ClockTable, ColumnTable
from identification.bring.streams.clocks import Clock
from identification.bring.streams.numbers import Numbers, numbers
from identification.bring.streams.stamps import from_numbers, from_texts, since_1970
from identification.bring.streams.together import Piece, together
from identification.bring.streams.units import UTC, unit_scale
from identification.campaign.faults import Fault
from identification.campaign.tables.columns import TIME, Column

_TIME = Column("t", TIME)


def read_piece(
    log: Log, said: Mapping[str, ColumnTable], known: Sequence[Column]
) -> tuple[Piece | None, tuple[Fault, ...]]:
    """A log's columns on one clock.

    Args:
        log: The log.
        said: What the mapping says of each column, `t` among them unless waveforms know it.
        known: The columns that the stream may have.

    Returns:
        The columns, None if there are faults; and the faults.
    """
    channels, faults = _channels(log, said)
    made: dict[str, Numbers] = {}
    for column in known:
        if column.name in channels and column.name != "t":
            result, fault = numbers(channels[column.name], column, said[column.name])
            faults += [] if fault is None else [fault]
            if result is not None:
                made[column.name] = result
    clocks: dict[str, Clock] = {}
    for name in made:
        clock, fault = _own_clock(log, channels[name], said[name].t)
        faults += [] if fault is None else [dataclasses.replace(fault, column=name)]
        if clock is not None:
            clocks[name] = clock
    if not faults:
        clock, note, fault = _stream_clock(log, said.get("t"), made, clocks, channels)
        if fault is None:
            rows = _by_rows(said, clocks, channels, len(clock.instants))
            own = {name: each for name, each in clocks.items() if name not in rows}
            return together(log, clock, note, made, own, counted=_is_counted(said))
        faults.append(fault)
    return None, tuple(dataclasses.replace(fault, file=str(log.path)) for fault in faults)


def _is_counted(said: Mapping[str, ColumnTable]) -> bool:
    return "t" in said and said["t"].rate is not None


def _by_rows(
    said: Mapping[str, ColumnTable],
    clocks: Mapping[str, Clock],
    channels: Mapping[str, Channel],
    count: int,
) -> set[str]:
    """Columns that a stated `t` stamps row by row, whatever default their waveform has.

    Waveforms that begin together and have as many samples as `t` were logged with it. Where
    one begins later than another, its own clock counts.
    """
    if "t" not in said:
        return set()
    forms = {name for name in clocks if said[name].t is None}
    starts = {(channels[name].waveform.epoch, channels[name].waveform.start) for name in forms}
    stamps = channels["t"].waveform if "t" in channels else None
    starts |= set() if stamps is None else {(stamps.epoch, stamps.start)}
    level = len(starts) <= 1 and all(len(clocks[name].instants) == count for name in forms)
    return forms if level else set()


def find(log: Log, text: str) -> tuple[Channel | None, str]:
    """The channel that a mapping means.

    Args:
        log: The log.
        text: Its name, with or without the unit that a header says; or its path in a MAT file.

    Returns:
        The channel, None if there is none or several; and why, where that isn't plain.
    """
    exact = log.channels.get(text.strip())
    if exact is not None:
        return exact, ""
    named = [each for name, each in log.channels.items() if bare(name) == text.strip()]
    if len(named) == 1:
        return named[0], ""
    if named:
        return None, f"{len(named)} channels of this name"
    channel, why = channel_of(text, log.channels)
    if channel is None:
        stem = re.split(r"[.\[({]", text.strip())[0]
        objects = [each for each in log.channels.values() if each.missing]
        inside = (each for each in objects if stem in (each.name, each.name.partition(".")[0]))
        return next(inside, None), why
    return channel, why


def _channels(
    log: Log, said: Mapping[str, ColumnTable]
) -> tuple[dict[str, Channel], list[Fault]]:
    found, faults = {}, []
    for name, column in said.items():
        if column.channel is None:
            if column.rate is None:
                faults.append(_left_empty(name))
            continue
        channel, why = find(log, column.channel)
        if channel is None:
            faults.append(_no_channel(log, name, column.channel, why))
        else:
            found[name] = channel
    return found, faults


def _left_empty(name: str) -> Fault:
    return Fault(
        what="its channel is left empty",
        column=name,
        got="no channel",
        expected='a name of the log: { channel = "…", unit = "…" }',
        remedy="Name the channel, or delete the line if it wasn't logged.",
    )


def _no_channel(log: Log, column: str, text: str, why: str) -> Fault:
    names = list(log.channels)
    near = difflib.get_close_matches(text, names, n=1)
    listed = ", ".join(map(repr, names[:12])) + (", …" if len(names) > 12 else "")
    return Fault(
        what=why or "no such channel",
        column=column,
        got=repr(text),
        expected=f"one of {listed}",
        remedy=f"Did you mean {near[0]!r}?" if near else "Correct the name in the mapping.",
    )


def _own_clock(
    log: Log, channel: Channel, said: ClockTable | None
) -> tuple[Clock | None, Fault | None]:
    """A channel's own clock, None if it shares the stream's."""
    if said is not None:
        return _stated_clock(log, said, len(channel.values))
    if channel.waveform is not None:
        form = channel.waveform
        return Clock(form.epoch, form.instants(len(channel.values))), None
    return None, None


def _stated_clock(log: Log, said: ClockTable, count: int) -> tuple[Clock | None, Fault | None]:
    """The clock that a mapping states."""
    if said.rate is not None:
        return Clock(None, np.arange(count) / said.rate), None
    channel, why = (None, "") if said.channel is None else find(log, said.channel)
    if channel is None:
        empty = said.channel is None
        return None, _left_empty("t") if empty else _no_channel(log, "t", said.channel, why)
    return stamped(channel, said)


def stamped(channel: Channel, said: ClockTable) -> tuple[Clock | None, Fault | None]:
    """The clock of a channel of times.

    Args:
        channel: The channel.
        said: What the mapping says of it.

    Returns:
        The clock, None if there is a fault; and the fault.
    """
    if channel.epoch is not None:
        clock = Clock(channel.epoch, channel.values)
    elif channel.is_text:
        made = from_texts(channel.values)
        if made is None:
            return None, _no_times(channel)
        clock = Clock(*made)
    else:
        table = said
        if not isinstance(said, ColumnTable):
            table = ColumnTable(channel=said.channel, unit=said.unit)
        if table.unit == UTC:
            table = table.model_copy(update={"unit": since_1970(channel.values)})
        result, fault = numbers(channel, _TIME, table)
        if result is None:
            return None, fault
        clock = Clock(*from_numbers(result.values))
        if channel.near is not None and clock.epoch is not None:
            clock = _near(channel, table)
    return clock, _not_increasing(channel, clock.instants)


def _near(channel: Channel, said: ColumnTable) -> Clock:
    """The clock of stamps that doubles would round: their digits are counted from nearby."""
    base, rest = channel.near
    scale = unit_scale(_TIME, said.unit or channel.unit)
    factor = Fraction(scale.factor) * Fraction(10) ** scale.exponent
    begin = base * factor * Fraction(said.scale)
    epoch = math.floor(begin)
    return Clock(epoch, float(begin - epoch) + scale(rest * said.scale))


def _no_times(channel: Channel) -> Fault:
    return Fault(
        what="texts that are no dates and times",
        column="t",
        got=f"{channel.values[0]!r} in {channel.name!r}",
        expected="stamps such as 2026-11-30T10:00:00.125",
        remedy='Name a channel of numbers with its unit, or state { rate = "1 kHz" }.',
    )


def _not_increasing(channel: Channel, instants: Float64[np.ndarray, " _"]) -> Fault | None:
    bad = ~np.isfinite(instants)
    bad[1:] |= ~(np.diff(instants) > 0)
    if not bad.any():
        return None
    sample = int(np.argmax(bad))
    return Fault(
        what="time doesn't increase",
        column="t",
        row=channel.row(sample),
        got=f"{channel.values[sample]} in {channel.name!r}, the first of {int(bad.sum())}",
        expected="a later time in every row",
        remedy="Cut the log there with `from` and `to` of pieces, or state a rate.",
    )


def _stream_clock(
    log: Log,
    said: ColumnTable | None,
    made: Mapping[str, Numbers],
    clocks: Mapping[str, Clock],
    channels: Mapping[str, Channel],
) -> tuple[Clock, str, Fault | None]:
    """The stream's own instants."""
    shared = {name: len(each.values) for name, each in made.items() if name not in clocks}
    if said is not None:
        count = next(iter(shared.values()), len(next(iter(made.values())).values))
        clock, fault = _stated_clock(log, said, count)
        if clock is None or fault is not None:
            return Clock(None, np.zeros(0)), "", fault
        note = (
            f"t is {said.channel!r}" if said.rate is None else f"t counts at {said.rate:g} Hz"
        )
        return clock, note, _unequal({**shared, "t": len(clock.instants)}, clocks)
    if not clocks or shared:
        return Clock(None, np.zeros(0)), "", _no_time(shared, clocks)
    name = min(clocks, key=lambda each: _preference(each, clocks))
    return clocks[name], f"t is the clock of {channels[name].name!r}", None


def _preference(name: str, clocks: Mapping[str, Clock]) -> tuple[int, int]:
    """Which clock is the stream's: the fastest, and of these the commands'."""
    fastest = min(clock.period for clock in clocks.values())
    slow = clocks[name].period > 1.5 * fastest
    return int(slow), list(clocks).index(name)


def _unequal(lengths: Mapping[str, int], clocks: Mapping[str, Clock]) -> Fault | None:
    if len(set(lengths.values())) <= 1:
        return None
    return Fault(
        what="channels of different lengths",
        got=", ".join(f"{name}: {length}" for name, length in lengths.items()),
        expected="as many samples in each that shares the stream's clock",
        remedy='Give the others a clock of their own: t = { channel = "…", unit = "s" }.',
    )


def _no_time(shared: Mapping[str, int], clocks: Mapping[str, Clock]) -> Fault:
    return Fault(
        what="no clock",
        column="t",
        got=f"no `t`, and no waveform's clock of {', '.join(shared) or 'any channel'}",
        expected='t = { channel = "…", unit = "s" } or t = { rate = "1 kHz" }',
        remedy="State when the samples were taken.",
    )
