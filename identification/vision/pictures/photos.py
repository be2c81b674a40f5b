"""Photos, one after the other, from the process that decodes them."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.pictures.photo_decoder import PHOTO
from identification.vision.pictures.stream import PIXELS, patience, read_into
from scdpr_jax.numerics.files.given import require_file

_HEADER = 200


def read_photos(photos: Sequence[Path]) -> Iterator[UInt8[np.ndarray, "height width 3"]]:
    """Read photos.

    Args:
        photos: The files.

    Yields:
        Each one's pixels, BGR.

    Raises:
        ValueError: If one can't be read; says which.
    """
    for photo in photos:
        require_file(photo, most=PHOTO)
    opencv()  # is there, or is named as missing
    command = [sys.executable, "-P", "-m", "identification.vision.pictures.photo_decoder"]
    child = subprocess.Popen(
        [*command, *(str(photo.resolve()) for photo in photos)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={
            **os.environ,
            "OPENCV_LOG_LEVEL": "OFF",
            "OPENCV_IO_MAX_IMAGE_PIXELS": f"{PIXELS}",
        },
    )
    try:
        for photo in photos:
            yield _next(child, photo)
    finally:
        child.kill()
        child.stdout.close()
        child.wait()


def _next(child: subprocess.Popen, photo: Path) -> UInt8[np.ndarray, "height width 3"]:
    """The photo that comes next."""
    with patience(child):
        line = child.stdout.readline(_HEADER)
        size = json.loads(line) if line.endswith(b"\n") else {"width": 0, "height": 0}
        width, height = size["width"], size["height"]
        if 0 < width * height <= PIXELS:
            picture = np.empty((height, width, 3), np.uint8)
            if read_into(child.stdout, memoryview(picture).cast("B")):
                return picture
    raise ValueError(
        f"calibration: {photo} is no picture that can be read. Delete it or export it "
        "again as JPEG or PNG."
    )
