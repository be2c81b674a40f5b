"""A folder that its user alone can read and write: for what is executed when it is found.

Compiled programs are code. Whoever can write where they are kept decides what the next process
runs, so such a folder is never relative (to wherever a command happens to be called), is the
user's own, and was never open to writing by others: what has lain there then can't be trusted.
"""

import os
import pathlib
import stat
import sys


def private_folder(folder: pathlib.Path) -> pathlib.Path:
    """A folder that is there, and closed to everybody else.

    Args:
        folder: Where it is to be.

    Returns:
        The same.

    Raises:
        PermissionError: If it is relative, another's, no folder, or open to others' writing.
        OSError: If it can't be made.
    """
    if not folder.is_absolute():
        raise PermissionError(f"{folder}: it is relative. Name it in full.")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if sys.platform == "win32":  # A user's folders are the user's there.
        return folder
    about = folder.lstat()
    if not stat.S_ISDIR(about.st_mode) or about.st_uid != os.geteuid():
        raise PermissionError(f"{folder}: it is another's, or no folder. Remove it.")
    if stat.S_IMODE(about.st_mode) & 0o022:
        raise PermissionError(f"{folder}: others can write there. Remove it: it is made anew.")
    if stat.S_IMODE(about.st_mode) & 0o055:
        folder.chmod(0o700)
    return folder
