"""What runs in the child process: reads files whose readers may crash, hang or eat memory.

Run as `python -m identification.bring.files.child OUT KIND PATH KIND PATH …`. What came of
the k-th file is `OUT/k.npz`. A reader that raises, or brings down its process, leaves
`OUT/k.ended` in its place, how it ended, and `OUT/k.said`, whose last line says why. Where a
process can't be copied, nothing is left, and the whole has ended.
"""

import contextlib
import json
import os
import pathlib
import signal
import sys
from collections.abc import Callable, Iterator

import numpy as np

from identification.bring.files.channel import Channel
from scdpr_jax.numerics.processes import end_with_parent

Reader = Callable[[pathlib.Path], list[Channel]]
"""What reads a file's channels."""
SECONDS = 1.5
"""Processor time that every file may take [s]."""
SECONDS_A_MEGABYTE = 3.0
"""What is added for each megabyte of a file [s]: TDMS of one sample a segment takes it."""
MEMORY = 2**29
"""Memory that every file may take [bytes]."""
MEMORY_A_BYTE = 60
"""What is added for each byte of a file: compressed numbers are ten times as long unpacked, and
are held as they are, as doubles, and on their way."""
MOST = 2**30
"""Memory that no file may exceed [bytes]."""
FULL_DISK = 74
"""How it ends where its results have no place."""


def seconds(path: pathlib.Path) -> float:
    """Processor time that a file may take.

    Args:
        path: The file.

    Returns:
        The time [s].
    """
    return SECONDS + SECONDS_A_MEGABYTE * path.stat().st_size / 1e6


def main(arguments: list[str]) -> None:
    """Read files one after the other.

    Args:
        arguments: A folder for the results; then a kind, "tdms", "mat" or "hdf5", and a path
            for each file.
    """
    end_with_parent()
    out, *files = arguments
    for number, (kind, name) in enumerate(zip(files[::2], files[1::2], strict=True)):
        reader, result = _reader(kind), pathlib.Path(out) / f"{number}.npz"
        if sys.platform == "win32":
            _read(reader, pathlib.Path(name), result)
        else:
            _read_apart(reader, pathlib.Path(name), result)


def _read(reader: Reader, path: pathlib.Path, result: pathlib.Path) -> None:
    with _limited(path):
        content = _packed(reader(path))
    scratch = result.with_suffix(".part.npz")
    try:
        np.savez(scratch, **content)
    except OSError as error:
        print(error.strerror, file=sys.stderr)
        sys.exit(FULL_DISK)
    scratch.replace(result)


def _read_apart(reader: Reader, path: pathlib.Path, result: pathlib.Path) -> None:
    """The same in a copy of this process, which has the libraries: it may die of the file.

    What it says, and how it ends, is left beside the result.
    """
    process = os.fork()
    if process == 0:
        end_with_parent()
        said = os.open(result.with_suffix(".said"), os.O_CREAT | os.O_WRONLY, 0o600)
        os.dup2(said, 2)
        _read(reader, path, result)
        os._exit(0)
    _, status = os.waitpid(process, 0)
    ended = os.waitstatus_to_exitcode(status)
    if ended == FULL_DISK:
        sys.exit(FULL_DISK)
    result.with_suffix(".ended").write_text(str(ended))


def _reader(kind: str) -> Reader:
    """A kind's reader; its library is loaded before the limits hold."""
    if kind == "tdms":
        from identification.bring.files.tdms import read_tdms

        return read_tdms
    if kind == "hdf5":
        from identification.bring.files.mat.hdf5 import read_hdf5

        return read_hdf5
    from identification.bring.files.mat.level5 import read_level5

    return read_level5


@contextlib.contextmanager
def _limited(path: pathlib.Path) -> Iterator[None]:
    """Limits of memory and of processor time, beyond which the system ends this process."""
    if sys.platform == "win32":
        yield
        return
    import resource

    used = _address_space()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    room = used + min(MEMORY + MEMORY_A_BYTE * path.stat().st_size, MOST)
    soft = room if hard == resource.RLIM_INFINITY else min(room, hard)
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    signal.setitimer(signal.ITIMER_PROF, seconds(path))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))


def _address_space() -> int:
    """Memory that this process has reserved already [bytes]."""
    status = pathlib.Path("/proc/self/statm")
    if not status.exists():
        return 2**33
    import resource

    return int(status.read_text().split()[0]) * resource.getpagesize()


def _packed(channels: list[Channel]) -> dict[str, np.ndarray]:
    """What is written: a description in JSON, and each channel's array."""
    rows = [
        {
            "name": channel.name,
            "unit": channel.unit,
            "label": channel.label,
            "epoch": channel.epoch,
            "missing": channel.missing,
            "waveform": None if channel.waveform is None else vars(channel.waveform),
        }
        for channel in channels
    ]
    text = json.dumps(rows).encode()
    arrays = {f"c{k}": channel.values for k, channel in enumerate(channels)}
    return {"description": np.frombuffer(text, dtype=np.uint8), **arrays}


if __name__ == "__main__":
    main(sys.argv[1:])
