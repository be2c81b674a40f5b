"""Logs that are written alike, and which of their columns were logged together."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Log
from identification.bring.proposal.look.signals import Looks, Signal, looks, signals


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Columns that were logged together, in every log of a layout."""

    signals: tuple[Signal, ...]
    """The columns, as the first log has them."""
    looks: tuple[Looks, ...]
    """What each looks like over all logs."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Layout:
    """Logs with the same channels."""

    paths: tuple[Path, ...]
    """The logs."""
    groups: tuple[Group, ...]
    """Their columns."""


def layouts(logs: Mapping[Path, Log]) -> list[Layout]:
    """Logs by what is in them.

    Args:
        logs: The logs by path.

    Returns:
        The layouts, that of the first log first.
    """
    found = {path: signals(log) for path, log in logs.items()}
    alike: dict[tuple[str, ...], list[Path]] = {}
    for path, columns in found.items():
        alike.setdefault(tuple(sorted(s.channel for s in columns)), []).append(path)
    return [
        Layout(paths=tuple(paths), groups=_groups([found[path] for path in paths]))
        for paths in alike.values()
        if found[paths[0]]
    ]


def _groups(columns: Sequence[list[Signal]]) -> tuple[Group, ...]:
    """Columns of one rate and about one length, those of the first log's order."""
    named = [{signal.channel: signal for signal in log} for log in columns]
    together: list[list[Signal]] = []
    for signal in columns[0]:
        home = next((group for group in together if _belongs(signal, group[0])), None)
        if home is None:
            together.append([signal])
        else:
            home.append(signal)
    return tuple(
        Group(
            signals=tuple(group),
            looks=tuple(looks([log[s.channel].values for log in named]) for s in group),
        )
        for group in together
    )


def _belongs(signal: Signal, other: Signal) -> bool:
    """Whether two columns were logged together: at one rate, about as long."""
    first, second = len(signal.values), len(other.values)
    rates = [None if s.waveform is None else s.waveform.increment for s in (signal, other)]
    if None not in rates and not np.isclose(*rates, rtol=0.3):
        return False
    return abs(first - second) <= 0.02 * max(first, second) + 25 * (None not in rates)
