"""A log's columns of numbers one by one, and what each looks like."""

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Channel, Log, Waveform
from identification.bring.files.csv.log import bare
from identification.bring.streams.stamps import from_texts

WIDEST = 24
"""Columns of an array that are looked at; a wider one is a picture or a spectrum."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Signal:
    """One column of numbers of a log."""

    channel: str
    """How a mapping names it."""
    words: str
    """What its own name says."""
    above: str
    """What stands above it: a group, a structure."""
    unit: str
    """Its unit as the log states it, empty where it doesn't."""
    values: Float64[np.ndarray, " samples"]
    """Its numbers; times [s] of stamps."""
    is_stamp: bool = False
    """Whether it holds dates and times."""
    waveform: Waveform | None = None
    """Its own clock, of a waveform."""
    own_time: str = ""
    """Channel of its own times, of a structure of time and data."""


def signals(log: Log) -> list[Signal]:
    """The columns of numbers of a log.

    Args:
        log: The log.

    Returns:
        One for each column, those of arrays one by one.
    """
    found = [signal for channel in log.channels.values() for signal in _columns(channel)]
    return _with_own_times(found)


def _columns(channel: Channel) -> Iterator[Signal]:
    if channel.missing:
        return
    # A header's slash or point is its unit's; only groups and structures have members.
    above, _, last = ("", "", channel.name)
    if channel.lines is None:
        above, _, last = _split(channel.name)
    words = channel.label or bare(last)
    if channel.is_text:
        made = from_texts(channel.values) if channel.values.size > 1 else None
        if made is not None:
            yield Signal(
                channel=channel.name, words=words, above=above, unit="UTC",
                values=made[1], is_stamp=True,
            )  # fmt: skip
        return
    values = channel.values
    if values.ndim == 1 and len(values) > 1:
        yield Signal(
            channel=channel.name, words=words, above=above, unit=channel.unit, values=values,
            is_stamp=channel.epoch is not None, waveform=channel.waveform,
        )  # fmt: skip
    if values.ndim == 2 and min(values.shape) <= WIDEST < max(values.shape):
        upright = values.shape[0] >= values.shape[1]
        for k, column in enumerate(values.T if upright else values):
            index = f"[:, {k}]" if upright else f"[{k}, :]"
            yield Signal(
                channel=channel.name + index, words=f"{words} {k + 1}", above=above,
                unit=channel.unit, values=np.ascontiguousarray(column),
            )  # fmt: skip


def _split(name: str) -> tuple[str, str, str]:
    """A channel's name parted before its last member."""
    mark = "/" if "/" in name and "." not in name.rpartition("/")[2] else "."
    above, point, last = name.rpartition(mark)
    if last.partition("[")[0] in ("values", "data", "Data", "Values") and above:
        inner, point, own = above.rpartition(mark)
        return inner, point, own
    return above, point, last


def _with_own_times(found: Sequence[Signal]) -> list[Signal]:
    """Signals of structures of time and data, each with its own time; the rest as they are."""
    times = {
        s.channel.rpartition(".")[0]: s
        for s in found
        if s.channel.rpartition(".")[2].lower() in ("time", "t", "timestamps")
    }
    owners = {
        parent: [
            s for s in found if s.channel.startswith(parent + ".") and s is not times[parent]
        ]
        for parent in times
        if parent
    }
    single = {parent for parent, inside in owners.items() if len(inside) == 1}
    if len(single) < 2:
        return list(found)
    first = times[min(single)]
    made = []
    for signal in found:
        parent = signal.channel.rpartition(".")[0]
        if parent not in single:
            made.append(signal)
        elif signal is not times[parent]:
            name = parent.rpartition(".")[2]
            same = times[parent].values.shape == first.values.shape and np.array_equal(
                times[parent].values, first.values
            )
            own = "" if same else times[parent].channel
            made.append(dataclasses.replace(signal, words=name, own_time=own))
        elif signal is first:
            made.append(signal)
    return made


@dataclasses.dataclass(frozen=True, kw_only=True)
class Looks:
    """What a signal looks like over all logs that have it."""

    size: float
    """Largest size."""
    spread: float
    """Largest minus smallest of one log, over the logs."""
    whole: bool
    """Whether all are whole numbers of a wide range."""
    jump: float
    """Largest step over the spread [1], of the log in which it jumps least."""
    starts_still: float
    """Share of logs that begin with ten equal numbers [1]."""
    starts_at_zero: float
    """Share of logs that begin with exactly zero [1]."""
    repeats: float
    """Share of samples that equal the one before [1]."""
    increases: bool
    """Whether each sample is later than the one before."""
    even: bool
    """Whether it does so in nearly equal steps."""
    step: float
    """Its middle step."""


def looks(columns: Sequence[Float64[np.ndarray, " _"]]) -> Looks:
    """What a signal looks like.

    Args:
        columns: Its numbers, of each log.

    Returns:
        Its looks.
    """
    seen = [column[np.isfinite(column)] for column in columns]
    seen = [column for column in seen if len(column) > 2] or [np.zeros(3)]
    steps = [np.diff(column) for column in seen]
    spreads = [float(np.ptp(column)) for column in seen]
    jumps = [
        float(np.abs(step).max()) / spread
        for step, spread in zip(steps, spreads, strict=True)
        if spread > 0
    ]
    middle = [float(np.median(step)) for step in steps]
    even = all(
        m > 0 and float(np.median(np.abs(step - m))) < 0.3 * m
        for step, m in zip(steps, middle, strict=True)
    )
    return Looks(
        size=max(float(np.abs(column).max()) for column in seen),
        spread=max(spreads),
        whole=max(spreads) > 20 and all(bool(np.all(c == np.rint(c))) for c in seen),
        jump=min(jumps, default=0.0),
        starts_still=float(np.mean([bool(np.all(c[:10] == c[0])) for c in seen])),
        starts_at_zero=float(np.mean([c[0] == 0 for c in seen])),
        repeats=float(np.mean([np.mean(step == 0) for step in steps])),
        increases=all(bool(np.all(step > 0)) for step in steps),
        even=even,
        step=float(np.median(middle)),
    )
