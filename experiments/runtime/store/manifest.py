"""What a store was begun with: for messages, and for whoever looks into its folder."""

import hashlib
import json
import pathlib
from collections.abc import Mapping
from typing import Any

from experiments.runtime.job import Job
from scdpr_jax.numerics.files import write_whole

MANIFEST = "manifest.json"
"""Name of its file."""


def inputs_of(job: Job, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that a job's results follow from, by name.

    Args:
        job: The job.
        inputs: What its caller names of it.

    Returns:
        It as JSON has it, with the key that its records are bound to.
    """
    about = {
        "computation": job.computation,
        "units": job.count,
        "inputs": inputs,
        "installation": dict(job.installation),
        "key": job.key.hex(),
    }
    return json.loads(json.dumps(about))


def write_manifest(folder: pathlib.Path, about: Mapping[str, Any]) -> None:
    """Write it.

    Args:
        folder: The store's folder.
        about: What the store is begun with.
    """
    text = json.dumps({**about, "checksum": _checksum(about)}, indent=1)
    write_whole(folder / MANIFEST, text + "\n")


def read_manifest(folder: pathlib.Path) -> dict[str, Any] | None:
    """What a store was begun with.

    Args:
        folder: Its folder.

    Returns:
        It; None where it isn't whole, or not there.
    """
    try:
        about = json.loads((folder / MANIFEST).read_bytes())
    except (FileNotFoundError, ValueError):
        return None
    if not isinstance(about, dict) or about.pop("checksum", "") != _checksum(about):
        return None
    return about


def differing(began: Mapping[str, Any], about: Mapping[str, Any]) -> list[str]:
    """What differs between two.

    Args:
        began: The one.
        about: The other.

    Returns:
        Names: of inputs, of parts of the installation, of what remains.
    """
    names = []
    for part in ("computation", "units"):
        names += [part] if began.get(part) != about[part] else []
    for part in ("inputs", "installation"):
        before, now = began.get(part, {}), about[part]
        names += [name for name in now if before.get(name) != now[name]]
    return names or ["what its units share"]


def _checksum(about: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
