"""A process that decodes photos and writes their pixels to its standard output.

As with videos, what decodes them is written for speed, and a damaged one can end its process.

The stream: for each photo a line of JSON with width and height, 0 where it is none that can be
decoded; then the rows of its pixels, BGR.
"""

import json
import os
import pathlib
import sys

from identification.vision.pictures.decoder import begin_picture, limit
from scdpr_jax.numerics.files.given import MEBIBYTE, read_given

PHOTO = 64 * MEBIBYTE
"""Largest photo [bytes]."""


def main() -> int:
    """Decode the photos that the arguments name.

    Returns:
        0 done.
    """
    limit()
    import numpy as np

    from identification.vision.pictures.opencv import opencv

    cv2 = opencv()
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)
        for name in sys.argv[1:]:
            begin_picture()
            content = np.frombuffer(read_given(pathlib.Path(name), most=PHOTO), np.uint8)
            try:
                picture = cv2.imdecode(content, cv2.IMREAD_COLOR) if len(content) else None
            except cv2.error:  # too large, or too little memory for it
                picture = None
            height, width = (0, 0) if picture is None else picture.shape[:2]
            out.write(json.dumps({"width": width, "height": height}).encode() + b"\n")
            if picture is not None:
                out.write(memoryview(np.ascontiguousarray(picture)).cast("B"))
            out.flush()
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except BrokenPipeError:  # nobody wants the rest
        sys.exit(0)
