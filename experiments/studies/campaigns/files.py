"""A campaign's files as bytes, on their way to whoever reads them."""

import pathlib
from collections.abc import Iterator

import numpy as np

from experiments.runtime.parcel import Parcel, packed
from identification.campaign.read import CAMPAIGN_FILE, RUN_FILE
from identification.campaign.streams import ACCELEROMETER_FILE, CAMERA_FILE, DRIVE_FILE

OF_A_RUN = (RUN_FILE, DRIVE_FILE, CAMERA_FILE, ACCELEROMETER_FILE)
"""Files of a run that format 1 knows: videos and notes stay where they are."""

LARGEST = 2**29
"""What the files of a campaign may hold together [bytes]: days of logs."""


def packed_files(folder: pathlib.Path) -> bytes:
    """A campaign's files.

    Args:
        folder: Its folder.

    Returns:
        The files and the folders of its runs as a parcel, packed; of what can't be read, the
        reason.
    """
    try:
        parcel = Parcel(*_contents(folder))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        parcel = Parcel({"refused": f"can't be read: {reason or type(error).__name__}"})
    return packed(parcel)


def unpack_files(parcel: Parcel, folder: pathlib.Path) -> None:
    """Write a campaign's files.

    Args:
        parcel: The files and folders.
        folder: The folder to make.

    Raises:
        ValueError: If it couldn't be read, or a name leads out of the folder.
    """
    if reason := parcel.facts.get("refused"):
        raise ValueError(reason)
    folder.mkdir()
    for name in parcel.facts["folders"]:
        _below(folder, name).mkdir()
    for name, content in parcel.arrays.items():
        _below(folder, name).write_bytes(content.tobytes())


def _below(folder: pathlib.Path, name: str) -> pathlib.Path:
    parts = name.split("/")
    if len(parts) > 2 or any(part in ("", ".", "..") or "\\" in part for part in parts):
        raise ValueError(f"a file's name leads out of its campaign: {name!r}")
    return folder.joinpath(*parts)


def _contents(folder: pathlib.Path) -> tuple[dict[str, list[str]], dict[str, np.ndarray]]:
    if not folder.is_dir():
        raise ValueError("there is no such folder")
    runs = sorted(
        each.name
        for each in folder.iterdir()
        if each.is_dir() and not each.name.startswith(".")
    )
    root, room, arrays = folder.resolve(), LARGEST, {}
    for name in _names(runs):
        path = folder / name
        if not path.exists():
            continue
        if not path.is_file() or not path.resolve().is_relative_to(root):
            raise ValueError(f"{name} is no file of this folder, expected a regular one in it")
        room -= path.stat().st_size
        if room < 0:
            raise ValueError(f"its files hold more than {LARGEST // 2**20} MiB")
        arrays[name] = np.frombuffer(path.read_bytes(), np.uint8)
    return {"folders": runs}, arrays


def _names(runs: list[str]) -> Iterator[str]:
    yield CAMPAIGN_FILE
    for run in runs:
        yield from (f"{run}/{name}" for name in OF_A_RUN)
