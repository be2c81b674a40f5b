"""Results of a long computation on the way: a folder that knows whether they are its own.

A file for each unit, which is there whole or not at all, and bound by a hash to everything that
it follows from. One file for all would be simpler; where a bit of it flips, what comes after is
lost with it. Nothing of the folder is believed: what is damaged, of other inputs or another
unit's is named, and computed anew.
"""

import contextlib
import hashlib
import pathlib
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from experiments.runtime.job import Job
from experiments.runtime.store.lock import LOCK, locked
from experiments.runtime.store.manifest import (
    MANIFEST,
    differing,
    inputs_of,
    read_manifest,
    write_manifest,
)
from experiments.runtime.store.record import opened, sealed
from scdpr_jax.numerics.files import write_bytes_whole, write_whole

FINISHED = "finished"
"""Name of the file that says what the results were put together to."""
_UNIT = re.compile(r"(\d{8,})\.unit", re.ASCII)
_SCRATCH = re.compile(r"\.scdpr-[0-9a-f]{8}-\d+-[0-9a-f]+\.tmp", re.ASCII)


class Distrusted(NamedTuple):
    """Something in a store that isn't used."""

    name: str
    """Name of its file."""
    why: str
    """What is wrong with it."""


class Store:
    """The results that a job has so far, in a folder that no other process writes to."""

    def __init__(
        self, folder: pathlib.Path, job: Job, distrusted: Callable[[Distrusted], None]
    ) -> None:
        """A store in a folder that is there and locked; see `claimed`.

        Args:
            folder: Its folder.
            job: What it keeps the results of.
            distrusted: Told what of it isn't used.
        """
        self.folder = folder
        self.job = job
        self.distrusted = distrusted

    def write(self, number: int, payload: bytes, content: bytes) -> None:
        """Keep a unit's result.

        Args:
            number: The unit's number.
            payload: What it was given by itself.
            content: The result.
        """
        record = sealed(self.job.identity(number, payload), content)
        write_bytes_whole(self._file(number), record)

    def name(self, number: int) -> str:
        """Name of a unit's file.

        Args:
            number: The unit's number.

        Returns:
            The name.
        """
        return f"{number:08d}.unit"

    def has(self, number: int) -> bool:
        """Whether anything is kept of a unit.

        Args:
            number: The unit's number.

        Returns:
            Whether there is.
        """
        return self._file(number).exists()

    def read(self, number: int, payload: bytes) -> bytes | None:
        """A unit's result.

        Args:
            number: The unit's number.
            payload: What it is given by itself.

        Returns:
            The result; None where there is none.

        Raises:
            ValueError: If what is there isn't it; says why.
        """
        try:
            record = self._file(number).read_bytes()
        except FileNotFoundError:
            return None
        return opened(self.job.identity(number, payload), record)

    @property
    def is_empty(self) -> bool:
        """Whether no result is kept."""
        return not any(map(self._is_units, (path.name for path in self.folder.iterdir())))

    def drop(self, number: int) -> None:
        """Remove what is kept of a unit.

        Args:
            number: The unit's number.
        """
        self._file(number).unlink(missing_ok=True)

    def finish(self, result: pathlib.Path) -> None:
        """Note what the results were put together to, before that has its name.

        Args:
            result: The file, whole.
        """
        write_whole(self.folder / FINISHED, _digest(result))

    def has_finished(self, result: pathlib.Path) -> bool:
        """Whether a file is what an earlier process has put the results together to.

        Args:
            result: The file.

        Returns:
            Whether it is, to the last bit.
        """
        try:
            noted = (self.folder / FINISHED).read_text("ascii")
        except (FileNotFoundError, UnicodeDecodeError):
            return False
        return noted == _digest(result)

    def strangers(self) -> Iterator[pathlib.Path]:
        """Files in the folder that are none of the store's."""
        for path in sorted(self.folder.iterdir()):
            if path.name not in (LOCK, MANIFEST, FINISHED) and not self._is_units(path.name):
                yield path

    def remove(self) -> None:
        """Remove all that is the store's, and its folder where nothing else is in it."""
        for number in range(self.job.count):
            self.drop(number)
        for name in (MANIFEST, FINISHED, LOCK):
            (self.folder / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def _is_units(self, name: str) -> bool:
        unit = _UNIT.fullmatch(name)
        if unit is None or (number := int(unit[1])) >= self.job.count:
            return False
        return name == self.name(number)

    def _file(self, number: int) -> pathlib.Path:
        return self.folder / self.name(number)


def _digest(path: pathlib.Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextlib.contextmanager
def claimed(
    folder: pathlib.Path,
    job: Job,
    inputs: Mapping[str, Any],
    distrusted: Callable[[Distrusted], None] = lambda each: None,
) -> Iterator[Store]:
    """A new store, or the one that the same job has left, for this process alone.

    Args:
        folder: Its folder.
        job: What it shall keep the results of.
        inputs: What the results follow from, as a message shall name it.
        distrusted: Told what isn't used of what an earlier call has left.

    Yields:
        The store.

    Raises:
        ValueError: If another process is at it, or another job has left its own there.
        OSError: If the place can't be written to.
    """
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(locked(folder))
        except BlockingIOError:
            raise ValueError(
                f"`--out`: another process is at it, got a lock on {folder}, expected none. "
                "Wait for that one, or name another file."
            ) from None
        store = Store(folder, job, distrusted)
        _take_over(store, inputs_of(job, inputs))
        yield store


def _take_over(store: Store, about: Mapping[str, Any]) -> None:
    """Make a folder the store's, and tell what of it isn't to be used."""
    began = read_manifest(store.folder)
    if began is not None and began != about:
        raise ValueError(
            f"`--out`: {store.folder} keeps what another call has begun "
            f"({', '.join(differing(began, about))} differ), expected the same to go on with. "
            "Give the call that began it, name another file, or remove the folder."
        )
    strangers = [path for path in store.strangers() if not _SCRATCH.fullmatch(path.name)]
    if strangers:
        names = ", ".join(repr(path.name) for path in strangers[:5])
        raise ValueError(
            f"`--out`: {store.folder} holds what isn't of this call, got {names}"
            f"{' and more' if len(strangers) > 5 else ''}, expected records of its units "
            "alone. Move it away, or name another file."
        )
    for path in store.strangers():
        path.unlink()  # A writer's that was killed, on a disk without nameless files.
    if began is None:
        if (store.folder / MANIFEST).exists():
            store.distrusted(
                Distrusted(MANIFEST, "damaged; records are told by their own seals")
            )
        write_manifest(store.folder, about)
