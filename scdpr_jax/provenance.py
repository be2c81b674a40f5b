"""Where a result comes from: which logs, when, by which version.

A file on a controller outlives the folder that it was made in. The logs are told by what they
hold and not by their path, so that a copy of them is known again.
"""

import datetime
import hashlib
import importlib.metadata
import os
import pathlib
from collections.abc import Iterable

from scdpr_jax.numerics.json_file import JsonObject

_SHORT = 16
"""Digits of a hash: no two campaigns of a lab have the same in so many."""


class Provenance(JsonObject, frozen=True):
    """Where a result comes from."""

    campaign: str = ""
    """Name of the campaign, or of the log."""
    source: str = ""
    """SHA-256 of the logs, its first digits; empty where they weren't files."""
    date: str = ""
    """Day on which it was made, UTC."""
    version: str = ""
    """Version of scdpr-jax."""

    def __str__(self) -> str:
        made = f"Made by scdpr-jax {self.version or '(unknown)'}"
        made += f" on {self.date}" if self.date else ""
        of = f" from {self.campaign!r}" if self.campaign else ""
        logs = f", logs SHA-256 {self.source}" if self.source else ""
        return f"{made}{of}{logs}."


UNKNOWN = Provenance()
"""Of what was made before files told it, or by hand."""


def made_today(campaign: str, source: str) -> Provenance:
    """The provenance of what is made now.

    Args:
        campaign: Name of the campaign, or of the log.
        source: Hash of the logs, see `hash_of`.

    Returns:
        It with today's date, or that of `SOURCE_DATE_EPOCH`, by which builds are repeated to
        the byte.
    """
    stamp = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.datetime.now(datetime.UTC)
    day = now if stamp is None else datetime.datetime.fromtimestamp(int(stamp), datetime.UTC)
    try:
        version = importlib.metadata.version("scdpr-jax")
    except importlib.metadata.PackageNotFoundError:
        version = ""
    return Provenance(
        campaign=campaign, source=source, date=day.date().isoformat(), version=version
    )


def of_no_day(campaign: str, source: str) -> Provenance:
    """The provenance of what may be gone on with tomorrow, and ends with the same bytes.

    Args:
        campaign: Name of the campaign, or of the log.
        source: Hash of the logs, see `hash_of`.

    Returns:
        It without a date.
    """
    return made_today(campaign, source).model_copy(update={"date": ""})


def hash_of(files: Iterable[pathlib.Path], folder: pathlib.Path) -> str:
    """A hash of files, whatever their folder is called and whenever they were written.

    Args:
        files: The files.
        folder: The folder that their names count from.

    Returns:
        The first digits of a SHA-256 over names and contents.
    """
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.relative_to(folder).as_posix().encode() + b"\0")
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:_SHORT]
