"""What a result depends on beyond what it is computed from: programs, versions, processor.

The same program on another processor may round otherwise (fused products, wider sums), and so
may another version of a library. Who computes with another installation than the one that a
computation was begun with is told so, before a bit of it is in a result.
"""

import functools
import hashlib
import importlib
import importlib.metadata
import os
import pathlib
import platform
from collections.abc import Mapping

_PACKAGES = ("scdpr_jax", "identification", "tuning", "experiments")
_LIBRARIES = (
    "scdpr-jax",
    "jax",
    "jaxlib",
    "numpy",
    "scipy",
    "pandas",
    "llvmlite",
    "equinox",
    "diffrax",
    "optimistix",
    "lineax",
    "optax",
)

Installation = Mapping[str, str]
"""What is installed, by name."""


@functools.cache
def installation() -> Installation:
    """This process's installation.

    Returns:
        Versions by library, a hash of this project's sources, Python, the system's kind, the
        processor, and whether NumPy shares out its sums.
    """
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features().flatten()
    kind = f"{llvm.get_host_cpu_name()} {hashlib.sha256(features.encode()).hexdigest()[:8]}"
    return {
        **{name: importlib.metadata.version(name) for name in _LIBRARIES},
        "sources": _sources(),
        "Python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": kind,
        "OPENBLAS_NUM_THREADS": os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
    }


def different(installed: Installation, expected: Installation) -> str:
    """How an installation differs from another one, in words.

    Args:
        installed: The installation.
        expected: The other one.

    Returns:
        What differs; empty for nothing.
    """
    names = [name for name in expected if installed.get(name) != expected[name]]
    return ", ".join(
        f"{name} {installed.get(name, 'unknown')} for {expected[name]}" for name in names
    )


def _sources() -> str:
    """A hash of this project's sources."""
    digest = hashlib.sha256()
    for name in _PACKAGES:
        (folder,) = map(pathlib.Path, importlib.import_module(name).__path__)
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.relative_to(folder).as_posix().encode() + b"\n")
            digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:16]
