"""A folder for what is needed for a moment, which doesn't outlive a process for long.

A process that is killed can't clear up. Its scratch folder is locked as long as it lives, so
that the next one knows which are nobody's any more.
"""

import contextlib
import getpass
import pathlib
import secrets
import shutil
import tempfile
from collections.abc import Iterator

from experiments.runtime.store.lock import locked
from scdpr_jax.numerics.private_folder import private_folder


@contextlib.contextmanager
def scratch_folder() -> Iterator[pathlib.Path]:
    """An empty folder that is removed in the end.

    Yields:
        The folder.

    Raises:
        OSError: If there is no place for it.
    """
    whole = private_folder(pathlib.Path(tempfile.gettempdir(), f"scdpr-{getpass.getuser()}"))
    for left in whole.iterdir():
        with contextlib.suppress(BlockingIOError), locked(left):
            shutil.rmtree(left, ignore_errors=True)
    own = whole / secrets.token_hex(8)
    with locked(own):
        try:
            yield own
        finally:
            shutil.rmtree(own, ignore_errors=True)
