"""MAT files of version 4 to 7, by SciPy, in the child process."""

import pathlib

import scipy.io

from identification.bring.files.channel import Channel
from identification.bring.files.mat.tree import channels


def read_level5(path: pathlib.Path) -> list[Channel]:
    """Channels of a MAT file of version 4 to 7.

    Args:
        path: The file.

    Returns:
        Every array of numbers or texts, by its path through structures and cells.
    """
    contents = scipy.io.loadmat(path, simplify_cells=False, squeeze_me=False)
    return channels({k: v for k, v in contents.items() if not k.startswith("__")})
