"""Names of what is kept: hashes of all that it depends on."""

import functools
import hashlib
import importlib
import inspect
import pathlib
import re
from collections.abc import Iterable
from typing import Any

import equinox as eqx
import jax
import numpy as np

from scdpr_jax.native.xla.interface import header

_UNNAMED = re.compile(r" at 0x[0-9a-f]+|<lambda>|<locals>")
"""What tells that a description holds in this process alone."""


def lasting_name(kind: str, parts: Iterable[Any], about: str) -> str:
    """The name of a file that is kept, by all that its content depends on.

    Functions and classes stand for the sources of their packages, and of this one.

    Args:
        kind: What is kept.
        parts: Functions and classes that it depends on, which are the same in any process,
            among what needs no name.
        about: All else that it depends on.

    Returns:
        The name; empty if some of it holds in this process alone.
    """
    functions = [part for part in parts if inspect.isroutine(part) or isinstance(part, type)]
    names = [f"{part.__module__}.{part.__qualname__}" for part in functions]
    for part in functions:
        about = about.replace(repr(part), "")
    about = " ".join([*names, about])
    if _UNNAMED.search(about):
        return ""
    try:
        texts = [sources(name) for name in sorted({n.split(".")[0] for n in names})]
        depends = (fingerprint(), *texts, jax.default_backend().encode())
    except (ImportError, OSError):
        return ""
    return f"{kind}_" + hashlib.sha256(b"".join([*depends, about.encode()])).hexdigest()[:40]


@functools.cache
def sources(package: str) -> bytes:
    """A hash of a package's sources, of those of this one, and of versions.

    Args:
        package: The package's name.

    Returns:
        The hash.
    """
    folders = {pathlib.Path(*importlib.import_module(own).__path__) for own in {package, _OWN}}
    files = sorted(file for folder in folders for file in folder.rglob("*.py"))
    versions = f"{jax.__version__} {eqx.__version__} {np.__version__}"
    return hashlib.sha256(
        b"".join([*(file.read_bytes() for file in files), versions.encode()])
    ).digest()


_OWN = __name__.split(".")[0]


@functools.cache
def fingerprint() -> bytes:
    """What all machine code depends on: these sources, versions and the processor.

    Returns:
        A hash.

    Raises:
        ImportError: If there is no llvmlite.
        OSError: If there is no header of XLA's interface.
    """
    import llvmlite
    import llvmlite.binding as llvm

    files = sorted(pathlib.Path(__file__).parents[1].rglob("*.py"))
    processor = (llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())
    versions = (jax.__version__, llvmlite.__version__, llvm.llvm_version_info)
    about = repr((versions, processor, header())).encode()
    return hashlib.sha256(b"".join([*(file.read_bytes() for file in files), about])).digest()
