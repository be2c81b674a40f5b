"""Machine code and programs kept on disk between processes, in a folder of the user's alone.

What is kept is executed, so it is trusted no further than its folder: that is the user's own,
closed to others, and never relative. Without JAX's compilation cache nothing is kept. A file
that isn't whole, or not what its name says, counts as none.
"""

import hashlib
import pathlib
import warnings

import jax

from scdpr_jax.numerics.files import whole_file
from scdpr_jax.numerics.files.private_folder import private_folder

_MARK = b"scdpr-jax code 2\n"


def folder() -> pathlib.Path | None:
    """Where code is kept: beside what JAX's compilation cache keeps.

    Returns:
        The folder, which is there and is the user's alone; none if JAX keeps nothing or the
        folder can't be trusted, which is said once.
    """
    cache = jax.config.jax_compilation_cache_dir
    if not cache or "://" in cache:
        return None
    try:
        return private_folder(pathlib.Path(cache, "native"))
    except OSError as reason:
        return _refused(reason)


def _refused(reason: OSError) -> None:
    warnings.warn(f"Compiled code isn't kept: {reason}", RuntimeWarning, stacklevel=2)


def kept(name: str) -> bytes | None:
    """Code from an earlier process.

    Args:
        name: Its file: what it depends on, hashed, and the kind of code.

    Returns:
        The code; none where there is none, or not a whole one of this name.
    """
    own = folder()
    if own is None:
        return None
    try:
        found = (own / name).read_bytes()
    except OSError:
        return None
    head = _MARK + name.encode() + b"\n"
    digest, code = found[len(head) : len(head) + 32], found[len(head) + 32 :]
    whole = found.startswith(head) and hashlib.sha256(code).digest() == digest
    return code if whole else None


def keep(name: str, code: bytes) -> None:
    """Keeps code for later processes, if there is a place for it.

    Args:
        name: Its file: what it depends on, hashed, and the kind of code.
        code: The code.
    """
    own = folder()
    if own is None:
        return
    head = _MARK + name.encode() + b"\n" + hashlib.sha256(code).digest()
    try:
        with whole_file(own / name) as part:
            part.chmod(0o600)
            part.write_bytes(head + code)
    except OSError as reason:
        _refused(reason)
