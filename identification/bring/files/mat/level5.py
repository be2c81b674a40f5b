"""MAT files of version 4 to 7, by SciPy, in the child process."""

import io
import pathlib
import warnings
from typing import Any

import numpy as np
import scipy.io
import scipy.io.matlab

from identification.bring.files.channel import Channel
from identification.bring.files.mat.store import Store
from identification.bring.files.mat.tree import channels, class_of, name_of

_HEADER, _TAG = 128, 8
"""Bytes of a file's header, and of what stands before an element."""
_LITTLE = b"\x00\x01IM"
"""Version and order of the bytes, as the hidden part begins."""


def read_level5(path: pathlib.Path) -> list[Channel]:
    """Channels of a MAT file of version 4 to 7.

    Args:
        path: The file.

    Returns:
        Every array of numbers or texts, by its path through structures and cells.
    """
    with warnings.catch_warnings():
        # SciPy has all objects under one name, the last one alone: they are read again below.
        warnings.filterwarnings("ignore", "Duplicate variable name")
        contents = scipy.io.loadmat(path, simplify_cells=False, squeeze_me=False)
    hidden = contents.get("__function_workspace__")
    objects = _objects(path) if hidden is not None else {}
    if objects:
        del contents["None"]
    variables = {k: v for k, v in contents.items() if not k.startswith("__")}
    return channels(variables | objects, _store(hidden))


def _objects(path: pathlib.Path) -> dict[str, Any]:
    """The variables that are objects of MATLAB's own, each by its name."""
    objects = {}
    with path.open("rb") as file:
        for name, alone in scipy.io.matlab.varmats_from_mat(file):
            if name == "None":
                value = scipy.io.loadmat(alone).get("None")
                if class_of(value):
                    objects[name_of(value)] = value
    return objects


def _store(hidden: Any) -> Store | None:
    """The properties of objects, in a part that is a file of one variable without a name."""
    if hidden is None or hidden.dtype != np.uint8:
        return None
    content = hidden.tobytes()
    if content[:4] != _LITTLE:
        return None
    size = int.from_bytes(content[12:16], "little")
    text = b"MATLAB".ljust(_HEADER - len(_LITTLE), b"\0")
    file = io.BytesIO(text + _LITTLE + content[8 : 8 + _TAG + size])
    try:
        inner = scipy.io.loadmat(file)["__function_workspace__"]
        wrapper = np.ravel(np.ravel(inner["MCOS"])[0])[0]
        return Store.of(list(np.ravel(wrapper["arr"])))
    except (ValueError, IndexError, KeyError):
        return None
