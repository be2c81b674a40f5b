"""LabVIEW's TDMS files, in the child process: every channel with its own clock."""

import pathlib
from collections.abc import Mapping
from typing import Any

import nptdms
import numpy as np
from nptdms.timestamp import TimestampArray

from identification.bring.files.channel import Channel, Waveform

_EPOCH = 2082844800
"""Seconds from 1904, where LabVIEW's time begins, to 1970."""
_FRACTION = 2.0**-64
"""Unit of the fraction of LabVIEW's time stamps [s]."""
_UNITS = ("unit_string", "NI_UnitDescription", "unit", "Unit", "units")
"""Properties that state a unit."""


def read_tdms(path: pathlib.Path) -> list[Channel]:
    """Channels of a TDMS file.

    Args:
        path: The file.

    Returns:
        Every channel that has samples, by "group/channel".
    """
    # Stamps as the file has them: npTDMS's own are rounded to a microsecond.
    file = nptdms.TdmsFile.read(path, raw_timestamps=True)
    return [
        _channel(group.name, channel)
        for group in file.groups()
        for channel in group.channels()
        if len(channel)
    ]


def _channel(group: str, channel: nptdms.TdmsChannel) -> Channel:
    values, epoch = _values(channel[:])
    properties = channel.properties
    unit = next((str(properties[name]) for name in _UNITS if name in properties), "")
    return Channel(
        name=f"{group}/{channel.name}",
        values=values,
        unit=unit,
        epoch=epoch,
        waveform=_waveform(properties),
    )


def _values(content: Any) -> tuple[np.ndarray, int | None]:
    """A channel's numbers, and what stamps count from."""
    if isinstance(content, TimestampArray):
        whole = np.asarray(content["seconds"]).astype(np.int64) - _EPOCH
        origin = int(whole[0])
        fraction = np.asarray(content["second_fractions"]).astype(np.float64) * _FRACTION
        return (whole - origin).astype(np.float64) + fraction, origin
    array = np.asarray(content)
    if array.dtype.kind in "fiub":
        return array.astype(np.float64), None
    return array.astype(str), None


def _waveform(properties: Mapping[str, Any]) -> Waveform | None:
    """The clock of a waveform, None of a channel that is none."""
    increment = float(properties.get("wf_increment", 0.0))
    if not increment > 0:
        return None
    offset = float(properties.get("wf_start_offset", 0.0))
    start = properties.get("wf_start_time")
    if start is None:
        return Waveform(epoch=None, start=offset, increment=increment)
    fraction = float(start.second_fractions) * _FRACTION
    epoch = int(start.seconds) - _EPOCH
    if epoch == -_EPOCH and fraction == 0:  # a start that was never set
        return Waveform(epoch=None, start=offset, increment=increment)
    return Waveform(epoch=epoch, start=fraction + offset, increment=increment)
