"""A path into a MAT file: `logs.Rig.alpha[:, 0]`, `simout(:,2)`, `ScopeData.signals(3).values`.

Square brackets count from 0 as Python does, round and curly ones from 1 as MATLAB does.
"""

import dataclasses
import re
from collections.abc import Mapping

import numpy as np

from identification.bring.files.channel import Channel

_INDEX = re.compile(r"\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}")
_SIGNAL = re.compile(r"((?:\[[^\[\]]*\]|\([^()]*\)|\{[^{}]*\})*)\s*$")


def channel_of(path: str, channels: Mapping[str, Channel]) -> tuple[Channel | None, str]:
    """The channel of a path, with the column that its last indices choose.

    Args:
        path: The path.
        channels: The file's channels by their own paths.

    Returns:
        The channel with its chosen numbers, None if there is none; and why.
    """
    for name, rest in _readings(path):
        channel = channels.get(name)
        if channel is not None:
            return _chosen(channel, path, rest)
    return None, ""


def _readings(path: str) -> list[tuple[str, list[tuple[str, ...]]]]:
    """What a path can mean: a channel's own path, and the indices that choose from it.

    The last indices choose from an array, or they are those of a cell that holds it.
    """
    path = path.strip()
    tail = _SIGNAL.search(path)[1]
    stem = path[: len(path) - len(tail)]
    groups = [_zero_based(match) for match in _INDEX.finditer(tail)]
    inner = _INDEX.sub(lambda match: _canonical(_zero_based(match)), stem)
    readings = [(path, [])]
    for count in range(len(groups) + 1):
        own = "".join(_canonical(group) for group in groups[:count])
        readings.append((inner + own, groups[count:]))
        # A structure that isn't an array is its own first element.
        readings.append((re.sub(r"\[0\](?=\.)", "", inner) + own, groups[count:]))
        if all(group == ("0",) for group in groups[:count]):
            readings.append((re.sub(r"\[0\](?=\.)", "", inner), groups[count:]))
    return readings


def _zero_based(match: re.Match) -> tuple[str, ...]:
    """Indices that count from 0."""
    inside = next(group for group in match.groups() if group is not None)
    parts = tuple(part.strip() for part in inside.split(","))
    if match[1] is not None:
        return parts
    return tuple(str(int(p) - 1) if p.isdecimal() and p != "0" else p for p in parts)


def _canonical(indices: tuple[str, ...]) -> str:
    """Indices of a cell or of a structure as channels have them."""
    solid = [index for index in indices if index not in ("", "0")]
    return f"[{(solid or ['0'])[0]}]"


def _chosen(
    channel: Channel, path: str, groups: list[tuple[str, ...]]
) -> tuple[Channel | None, str]:
    """A channel with the numbers that indices choose."""
    if channel.missing or not groups:
        return channel, ""
    shape = channel.values.shape
    if len(groups) > 1:
        return None, f"indices twice, of an array of shape {shape}"
    indices = list(groups[0])
    if any(index != ":" and not re.fullmatch(r"-?\d+", index) for index in indices):
        return None, "indices that are neither numbers nor ':'"
    if channel.values.ndim == 1:
        # A column that is one already: [:, 0], (:, 1), [0, :].
        whole = [index for index in indices if index != ":"]
        if len(indices) > 2 or ":" not in indices or whole not in ([], ["0"]):
            return None, f"no such index, of an array of shape {shape}"
        return dataclasses.replace(channel, name=path), ""
    if len(indices) != channel.values.ndim or indices.count(":") != 1:
        return None, f"indices that choose no column, of an array of shape {shape}"
    place = tuple(slice(None) if index == ":" else int(index) for index in indices)
    for index, size in zip(place, shape, strict=True):
        if not isinstance(index, slice) and not -size <= index < size:
            return None, f"no such index, of an array of shape {shape}"
    return dataclasses.replace(
        channel, name=path, values=np.ascontiguousarray(channel.values[place])
    ), ""
