"""The pictures of a video, one after the other, from the process that decodes them."""

import contextlib
import dataclasses
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import UInt8

from identification.vision.pictures.decoder import FRAME
from identification.vision.pictures.opencv import opencv
from scdpr_jax.numerics.files.given import require_file

_PATIENCE = 60.0
_PIPE = 1 << 20
_HEADER = 1000
VIDEO = 32 << 30
"""Largest video [bytes]: an hour as a camera writes it."""
PIXELS = 1 << 26
"""Largest picture [px]."""
_REMEDY = (
    "Play it to the end in a player; if that fails, copy it again from the camera, or mend it "
    "with `ffmpeg -i BROKEN -c:v mjpeg -q:v 2 mended.avi`."
)


@dataclasses.dataclass(frozen=True)
class Frame:
    """One picture of a video."""

    number: int
    """Its place among the stored ones, from 0."""
    time: float
    """Its time as the container has it [s]."""
    change: float
    """Largest mean difference of a block from the picture before [levels]."""
    picture: UInt8[np.ndarray, "height width 3"]
    """Its pixels, BGR; valid until the next one is asked for."""


@dataclasses.dataclass(frozen=True)
class Video:
    """A video that is being read."""

    width: int
    """Pixels of a row."""
    height: int
    """Rows."""
    rate: float
    """Frames a second as the container has it [Hz]."""
    count: int
    """Frames as the container has them; 0 or less where it doesn't say."""
    frames: Iterator[Frame]
    """The pictures, once."""


@contextlib.contextmanager
def pictures(path: Path, *, step: int = 1) -> Iterator[Video]:
    """Read a video.

    Args:
        path: The file.
        step: Every how manieth picture is wanted.

    Yields:
        The video.

    Raises:
        ValueError: If it can't be read, here or while it is read.
    """
    try:
        require_file(path, most=VIDEO)
    except FileNotFoundError:
        raise ValueError(
            f"{path}: no such video. Check the key `video` and its path."
        ) from None
    opencv()  # is there, or is named as missing
    environment = {**os.environ, "OPENCV_LOG_LEVEL": "OFF", "OPENCV_FFMPEG_LOGLEVEL": "-8"}
    # Not what happens to lie in the working directory.
    command = [sys.executable, "-P", "-m", "identification.vision.pictures.decoder"]
    child = subprocess.Popen(
        [*command, str(path.resolve()), str(step)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )
    _widen(child.stdout)
    try:
        yield _opened(child, path, step)
    finally:
        child.kill()
        child.stdout.close()
        child.stderr.close()
        child.wait()


def _widen(pipe: BinaryIO) -> None:
    """A pipe that holds more, where there is such a thing: fewer changes between processes."""
    if sys.platform == "linux":
        import fcntl

        with contextlib.suppress(OSError):
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, _PIPE)


def _opened(child: subprocess.Popen, path: Path, step: int) -> Video:
    with patience(child):
        line = child.stdout.readline(_HEADER)
    if not line.endswith(b"\n"):
        raise _broken(child, path, "nothing that can be decoded")
    header = json.loads(line)
    if header["width"] * header["height"] > PIXELS:
        raise _broken(child, path, f"pictures of {header['width']} x {header['height']} px")
    frames = _frames(child, path, header["width"], header["height"], step)
    return Video(header["width"], header["height"], header["rate"], header["frames"], frames)


def _frames(
    child: subprocess.Popen, path: Path, width: int, height: int, step: int
) -> Iterator[Frame]:
    number = 0
    picture = np.empty((height, width, 3), np.uint8)
    head = bytearray(FRAME.size)
    while True:
        with patience(child):
            whole = read_into(child.stdout, memoryview(head))
            pixels = whole and read_into(child.stdout, memoryview(picture).cast("B"))
        if not pixels:
            break
        time, change = FRAME.unpack(head)
        yield Frame(number * step, time, change, picture)
        number += 1
    if child.wait() != 0:
        raise _broken(child, path, f"{number * step} pictures, and then no more")


def read_into(stream: BinaryIO, target: memoryview) -> bool:
    """Fill a piece of memory.

    Args:
        stream: What to read.
        target: The memory.

    Returns:
        Whether it was filled; not so at the end of the stream.
    """
    while len(target):
        length = stream.readinto1(target)
        if not length:
            return False
        target = target[length:]
    return True


@contextlib.contextmanager
def patience(child: subprocess.Popen) -> Iterator[None]:
    """End a process that says nothing for too long.

    Args:
        child: The process.

    Yields:
        Nothing.
    """
    timer = threading.Timer(_PATIENCE, child.kill)
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _broken(child: subprocess.Popen, path: Path, got: str) -> ValueError:
    said = child.stderr.read().decode(errors="replace").strip().splitlines()
    reason = f" ({said[-1][:120]})" if said else ""
    return ValueError(f"{path}: the video can't be read, got {got}{reason}. {_REMEDY}")
