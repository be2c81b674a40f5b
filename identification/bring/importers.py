"""Logs of LabVIEW (TDMS) and MATLAB (MAT) as drive streams."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from identification.campaign.faults import CampaignError, Fault, listed
from identification.campaign.streams import drive_stream
from identification.campaign.tables.columns import drive_columns
from identification.campaign.tables.header import Header, read_header
from identification.campaign.types import DriveStream


def import_drive_stream(
    path: str | Path, *, columns: Mapping[str, str], counts_per_rev: float | None = None
) -> DriveStream:
    """The controller's stream from a TDMS or MAT file.

    Args:
        path: The file, `.tdms` or `.mat` (version 7 or older).
        columns: For each header of `drive.csv`, like "voltage_1 [mV]", where its numbers
            are: "group/channel" of a TDMS file; a variable of a MAT file, with points into
            structures. A TDMS file without a column `t` gives the time of the waveform
            that its first channel is.
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], for [count].

    Returns:
        The stream in SI units and radians.

    Raises:
        CampaignError: If a header, a channel or a number isn't as it should be.
        ValueError: If the file is of another kind.
    """
    path = Path(path)
    readers = {".tdms": _read_tdms, ".mat": _read_mat}
    if path.suffix.lower() not in readers:
        raise ValueError(
            f"{path}: not a log that can be imported, got {path.suffix!r}, expected .tdms or "
            ".mat. Export it to CSV, with headers like `voltage_1 [V]`."
        )
    numbers = readers[path.suffix.lower()](path, columns)
    header, faults = read_header(tuple(numbers), drive_columns(counts_per_rev))
    _refuse(path, faults or _number_faults(numbers, header))
    cells = tuple(numbers.values())
    return drive_stream(
        {column.name: header.scale(k)(cells[k]) for k, column in header.columns.items()},
        {header.cells[place]: cells[place] for place in header.extra},
    )


def _refuse(path: Path, faults: Sequence[Fault]) -> None:
    """Raise what is wrong with a file, if anything is."""
    if faults:
        raise CampaignError(path, listed(faults, file=path.name))


def _read_tdms(
    path: Path, columns: Mapping[str, str]
) -> dict[str, Float64[np.ndarray, " rows"]]:
    import nptdms

    file = nptdms.TdmsFile.read(path)
    channels = {
        f"{group.name}/{channel.name}": channel
        for group in file.groups()
        for channel in group.channels()
    }
    chosen = _chosen(channels, columns, path)
    numbers = {header: _real(channel[:], header, path) for header, channel in chosen.items()}
    if any(header.split(" [")[0] == "t" for header in columns):
        return numbers
    first = next(iter(chosen.values()), None)
    if first is None or "wf_increment" not in first.properties:
        return numbers
    return {"t [s]": _real(first.time_track(), "t [s]", path), **numbers}


def _read_mat(
    path: Path, columns: Mapping[str, str]
) -> dict[str, Float64[np.ndarray, " rows"]]:
    import scipy.io

    try:
        contents = scipy.io.loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise ValueError(
            f"{path}: a MAT file of version 7.3, expected version 7 or older. "
            'Save it again in MATLAB with `save(name, "-v7")`.'
        ) from None
    chosen = _chosen(_flat(contents, ""), columns, path)
    return {header: _real(numbers, header, path) for header, numbers in chosen.items()}


def _flat(contents: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """A MAT file's variables, those inside of structures by their names with points."""
    variables: dict[str, Any] = {}
    for name, value in contents.items():
        if isinstance(value, Mapping):
            variables |= _flat(value, f"{prefix}{name}.")
        elif not name.startswith("__"):
            variables[prefix + name] = value
    return variables


def _chosen(there: Mapping[str, Any], columns: Mapping[str, str], path: Path) -> dict[str, Any]:
    faults = [
        Fault(
            what="no such channel",
            column=header,
            got=repr(name),
            expected=f"one of {', '.join(there) or 'none: the file is empty'}",
            remedy="Correct the name in `columns`.",
        )
        for header, name in columns.items()
        if name not in there
    ]
    _refuse(path, faults)
    return {header: there[name] for header, name in columns.items()}


def _real(numbers: Any, header: str, path: Path) -> Float64[np.ndarray, " rows"]:
    array = np.asarray(numbers)
    if array.dtype.kind not in "fiub" or array.ndim != 1:
        fault = Fault(
            what="not a column of numbers",
            column=header,
            got=f"shape {array.shape} of type {array.dtype}",
            expected="real numbers in one row or column",
            remedy="Name another channel in `columns`.",
        )
        _refuse(path, [fault])
    return array.astype(np.float64)


def _number_faults(
    numbers: Mapping[str, Float64[np.ndarray, " _"]], header: Header
) -> list[Fault]:
    lengths = {name: len(column) for name, column in numbers.items()}
    rows = next(iter(lengths.values()))
    if rows < 2 or len(set(lengths.values())) > 1:
        fault = Fault(
            what="channels of different lengths" if rows >= 2 else "too few samples",
            got=", ".join(f"{name}: {length}" for name, length in lengths.items()),
            expected="at least two samples, as many in every channel",
            remedy="Log all channels in one loop, or resample them.",
        )
        return [fault]
    faults = []
    for place, column in header.columns.items():
        channel = numbers[header.cells[place]]
        bad = ~np.isfinite(channel)
        if column.name == "t":
            bad[1:] |= ~(np.diff(channel) > 0)
        if bad.any():
            faults.append(_first_bad(bad, channel, header.cells[place]))
    return faults


def _first_bad(
    bad: Bool[np.ndarray, " rows"], channel: Float64[np.ndarray, " rows"], header: str
) -> Fault:
    sample = int(np.argmax(bad))
    finite = bool(np.isfinite(channel[sample]))
    return Fault(
        what="time doesn't increase" if finite else "not a finite number",
        row=sample + 1,
        column=header,
        got=f"{channel[sample]:.17g}, the first of {int(bad.sum())}",
        expected="a later time in every row" if finite else "a finite number",
        remedy="Cut the log before it, or log that channel again.",
    )
