"""Reading files in a child process: what brings down their reader is a file's fault.

SciPy's reader of MAT files, npTDMS and HDF5 trust what they read. A damaged file makes them
follow a wrong address, count to 10^9 or ask for all memory there is; an `except` can't hold
that. A process of its own can be ended, and the system tells how it ended.
"""

import dataclasses
import errno
import json
import os
import signal
import subprocess
import sys
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from identification.bring.files.channel import Channel, Waveform
from identification.bring.files.child import FULL_DISK, seconds
from identification.campaign.faults import Fault
from identification.campaign.quantities import LARGEST
from scdpr_jax.numerics.files.scratch import scratch_folder

PATIENCE = 6.0
"""Time over processor time that a child may take: others want the processor too."""
TOGETHER = 500
"""Files of one child: a command line isn't endless."""
START = 30.0
"""Time that a child may take to begin [s]."""


def read_in_child(files: Sequence[tuple[str, Path]]) -> list[list[Channel] | Fault]:
    """Channels of files whose readers aren't hardened.

    Args:
        files: A kind, "tdms", "mat" or "hdf5", and a path for each.

    Returns:
        For each file its channels, or what is wrong with it.
    """
    results: list[list[Channel] | Fault] = []
    while len(results) < len(files):
        results += _one_child(files[len(results) :][:TOGETHER])
    return results


def _one_child(files: Sequence[tuple[str, Path]]) -> list[list[Channel] | Fault]:
    """What one child makes of the first of some files: of all, or up to one that ended it."""
    with scratch_folder() as out:
        ended = _run(out, files)
        results = list(_results(out, files))
    if len(results) < len(files):
        results.append(_fault(files[len(results)][1], ended))
    return results


def _run(out: Path, files: Sequence[tuple[str, Path]]) -> str:
    """Let a child read files, and say how it ended."""
    words = [word for kind, path in files for word in (kind, str(Path(path).absolute()))]
    limit = START + PATIENCE * sum(seconds(path) for _, path in files)
    # Not what happens to lie in the working directory.
    command = [sys.executable, "-P", "-m", "identification.bring.files.child", str(out), *words]
    # A child whose path begins where this one's does finds the same packages.
    home = str(Path(__file__).parents[3])
    known = os.environ.get("PYTHONPATH")
    environment = {**os.environ, "PYTHONPATH": home + (os.pathsep + known if known else "")}
    try:
        child = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=limit,
            check=False,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        return "no end"
    if child.returncode == FULL_DISK:
        raise OSError(errno.ENOSPC, "No space left on device", str(out))
    return _reason(child.returncode, child.stderr)


def _reason(ended: int, said: bytes) -> str:
    """Why a process ended.

    Args:
        ended: Its exit status; minus the signal that ended it.
        said: What it said of itself.
    """
    if sys.platform != "win32" and ended == -signal.SIGPROF:
        return "more time than a file of its size can need"
    if ended < 0:
        return f"an end of its reader by {signal.Signals(-ended).name}"
    lines = said.decode(errors="replace").strip().splitlines()
    return lines[-1][:300] if lines else f"an end of its reader with status {ended}"


def _results(out: Path, files: Sequence[tuple[str, Path]]) -> Iterator[list[Channel] | Fault]:
    """What came of the first of some files: of all, or up to one that ended the whole."""
    for number, (_, path) in enumerate(files):
        result = out / f"{number}.npz"
        ended = result.with_suffix(".ended")
        if result.exists():
            yield _unpacked(result, path)
        elif ended.exists():
            said = result.with_suffix(".said").read_bytes()
            yield _fault(path, _reason(int(ended.read_text()), said))
        else:
            return


def _unpacked(result: Path, path: Path) -> list[Channel] | Fault:
    """A file's channels; what a broken child wrote isn't trusted either."""
    try:
        with np.load(result, allow_pickle=False) as content:
            rows = json.loads(content["description"].tobytes())
            return [_channel(row, content[f"c{k}"]) for k, row in enumerate(rows)]
    except (ValueError, KeyError, TypeError, OSError, zipfile.BadZipFile):
        return _fault(path, "an answer of its reader that makes no sense")


def _channel(row: dict, values: np.ndarray) -> Channel:
    waveform = row.pop("waveform")
    if values.dtype.kind == "f":
        # What no sensor measures is no number: a mark of what is missing, or damage.
        values = np.where(np.abs(values) <= LARGEST, values, np.nan)
    return Channel(
        **row, values=values, waveform=None if waveform is None else Waveform(**waveform)
    )


def _fault(path: Path, got: str) -> Fault:
    return Fault(
        what="the file is damaged, or isn't what its name says",
        file=str(path),
        got=got,
        expected="a TDMS or MAT file that its own program opens",
        remedy="Copy or export it again; if its program opens it, save it in another version.",
    )


def own(channels: Sequence[Channel]) -> dict[str, Channel]:
    """Channels by name; of equal names the later ones get a number.

    Args:
        channels: The channels.

    Returns:
        Each under a name of its own.
    """
    named: dict[str, Channel] = {}
    for channel in channels:
        name, number = channel.name, 2
        while name in named:
            name, number = f"{channel.name} ({number})", number + 1
        named[name] = dataclasses.replace(channel, name=name)
    return named
