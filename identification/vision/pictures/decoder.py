"""A process that decodes a video and writes its pictures to its standard output.

Libraries that decode videos are written in C for speed, and a damaged file can end the process
they run in. So they run in one of their own: what it leaves behind when it dies is an end of
the stream. It also has a core to itself, while what is found in the pictures is measured on
another. Its memory is limited, as a damaged header may ask for any.

The stream: a line of JSON with width, height, rate and the number of frames that the file
says it has; then for each frame a record of `FRAME` and the rows of its pixels, BGR.
"""

import json
import os
import signal
import struct
import sys
from typing import BinaryIO

from scdpr_jax.numerics.processes import end_with_parent

FRAME = struct.Struct("<dd")
"""Time by the container [s], and how much it differs from the picture before, see `change`."""
_BLOCK = 16
_ADDRESSES = 8 << 30
_MEMORY = 1 << 30
_SECONDS = 4.0
"""Processor time that a picture may take [s]: a large one takes a tenth of a second."""


def main() -> int:
    """Decode the video that the first argument names.

    Returns:
        0 done, 1 with a line on standard error if it can't be opened.
    """
    limit()
    from identification.vision.pictures.opencv import opencv

    cv2 = opencv()
    path, step = sys.argv[1], int(sys.argv[2])
    begin_picture()
    capture = cv2.VideoCapture(path)
    if not capture.isOpened():
        print("no video that can be decoded", file=sys.stderr)
        return 1
    # The pipe itself: text that a library prints must not get between the pictures.
    with os.fdopen(os.dup(1), "wb", buffering=0) as out:
        os.dup2(2, 1)
        return _decode(cv2, capture, out, step)


def _decode(cv2: object, capture: object, out: BinaryIO, step: int) -> int:
    number, last = 0, None
    while True:
        begin_picture()
        read, picture = capture.read()
        if not read:
            break
        if number == 0:
            header = {
                "width": picture.shape[1],
                "height": picture.shape[0],
                "rate": capture.get(cv2.CAP_PROP_FPS),
                "frames": int(capture.get(cv2.CAP_PROP_FRAME_COUNT)),
            }
            out.write(json.dumps(header).encode() + b"\n")
        green = picture[:, :, 1].copy()
        if number % step == 0:
            time = capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
            _write_all(out, FRAME.pack(time, change(cv2, last, green)))
            _write_all(out, memoryview(picture).cast("B"))
        last, number = green, number + 1
    if number == 0:
        print("no picture in it that can be decoded", file=sys.stderr)
        return 1
    return 0


def change(cv2: object, before: object, green: object) -> float:
    """How much a picture differs from the one before: the largest difference of a block.

    A doubled picture differs nowhere by more than what coding it twice costs. The mean over
    the picture would be simpler, and says nothing of a small robot before a large wall.

    Args:
        cv2: OpenCV.
        before: Green channel of the picture before; None for the first.
        green: Green channel of this one.

    Returns:
        The largest mean difference of a block of pixels [levels]; infinite for the first.
    """
    if before is None:
        return float("inf")
    height, width = (length // _BLOCK * _BLOCK for length in green.shape)
    difference = cv2.absdiff(before[:height, :width], green[:height, :width])
    size = (width // _BLOCK, height // _BLOCK)
    blocks = cv2.resize(difference.astype("float32"), size, interpolation=cv2.INTER_AREA)
    return float(blocks.max())


def _write_all(out: BinaryIO, content: bytes | memoryview) -> None:
    view = memoryview(content)
    while len(view):
        view = view[out.write(view) :]


def limit() -> None:
    """Bound this process: it ends with its parent, and has so much memory and no more."""
    end_with_parent()
    try:
        import resource
    except ImportError:  # Windows, where a process has no such limit
        return
    for kind, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_AS, _ADDRESSES),
        (resource.RLIMIT_DATA, _MEMORY),
    ):
        _, hard = resource.getrlimit(kind)
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (soft, hard))


def begin_picture() -> None:
    """Bound the processor time until this is called again; the system ends what exceeds it."""
    if sys.platform != "win32":
        signal.setitimer(signal.ITIMER_PROF, _SECONDS)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except BrokenPipeError:  # nobody wants the rest
        sys.exit(0)
