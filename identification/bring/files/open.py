"""Opening logs of any make: what each file is by its content, and which reader takes it."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from identification.bring.files.channel import Log
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.csv.log import read_csv
from identification.bring.files.parent import own, read_in_child
from identification.campaign.faults import Fault, fault_of
from scdpr_jax.numerics.files.given import LOG, FileError, require_file

_HDF5 = b"\x89HDF\r\n\x1a\n"
"""What an HDF5 file begins with, at 0 or behind a block of 512 bytes."""


def open_logs(
    paths: Iterable[tuple[Path, Dialect]],
) -> tuple[Mapping[Path, Log], tuple[Fault, ...]]:
    """Logs of any make.

    Args:
        paths: The files, each with what is known of how a text is written.

    Returns:
        The logs that can be read, by path; and what is wrong with the others.
    """
    wanted = dict(paths)
    logs: dict[Path, Log] = {}
    faults: list[Fault] = []
    binary: list[tuple[str, Path]] = []
    for path, dialect in wanted.items():
        fault = _unusable(path)
        kind = None if fault else _kind(path)
        if fault is not None:
            faults.append(fault)
        elif kind is not None:
            binary.append((kind, path))
        else:
            log, reasons = read_csv(path, dialect)
            faults += reasons
            if log is not None:
                logs[path] = log
    for (kind, path), content in zip(binary, read_in_child(binary), strict=True):
        if isinstance(content, Fault):
            faults.append(content)
        elif not content:
            faults.append(_empty(path))
        else:
            note = {"tdms": "TDMS", "mat": "MAT", "hdf5": "MAT of version 7.3"}[kind]
            logs[path] = Log(path=path, channels=own(content), notes=(note,))
    return {path: logs[path] for path in wanted if path in logs}, tuple(faults)


def _unusable(path: Path) -> Fault | None:
    """Why a path can't be a log: nothing is there, or what waits for ever."""
    try:
        require_file(path, most=LOG)
        path.open("rb").close()
    except FileError as error:
        return fault_of(error, file=str(path))
    except FileNotFoundError:
        got = "no such file"
    except OSError as error:
        got = f"{error.strerror}"
    else:
        return None
    return Fault(
        what="the log can't be read",
        file=str(path),
        got=got,
        expected="a file: CSV or another text in columns, TDMS, MAT",
        remedy="Check its name; in a mapping, paths count from the mapping's own folder.",
    )


def _kind(path: Path) -> str | None:
    """A file's kind, None of a text."""
    with path.open("rb") as file:
        head = file.read(520)
    if head.startswith(b"TDSm") or path.suffix.lower() == ".tdms":
        return "tdms"
    if head.startswith(_HDF5) or head[512:].startswith(_HDF5):
        return "hdf5"
    if path.suffix.lower() == ".mat" or head.startswith(b"MATLAB "):
        return "mat"
    return None


def _empty(path: Path) -> Fault:
    return Fault(
        what="the log has no channel",
        file=str(path),
        got="no samples",
        expected="one channel at least",
        remedy="Log it again, or name another file.",
    )
