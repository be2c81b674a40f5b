"""A job, run: what a store has isn't computed again, and what can't be is told."""

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Sequence

from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.store.store import Distrusted, Store
from scdpr_jax.numerics.progress import SILENT, Progress


@dataclasses.dataclass(frozen=True)
class Completion:
    """What came of running a job."""

    failures: dict[int, str]
    """Why units have no result, by their number; none of it is in the store."""
    distrusted: tuple[Distrusted, ...]
    """What of the store wasn't used, and was computed anew."""


def run(
    job: Job,
    store: Store,
    executor: Executor,
    *,
    words: Callable[[int], str] = lambda done: f"{done:,} units",
    progress: Progress = SILENT,
) -> Completion:
    """Compute every unit that the store hasn't.

    Args:
        job: The job.
        store: Where results are kept.
        executor: Who computes them.
        words: What is done, in words, when some units are.
        progress: Told what is being done and which share of it is done.

    Returns:
        What failed, and what the store had that isn't used.

    Raises:
        ValueError: If who computes can't be reached, or has another installation.
    """
    missing, distrusted = _missing(job, store, progress.part(0.0, 0.02))
    failures: dict[int, str] = {}
    done = job.count - len(missing)
    progress("beginning" if missing else words(done), done / job.count)
    payloads: dict[int, bytes] = {}

    def payload(number: int) -> bytes:
        payloads[number] = job.payload(number)
        return payloads[number]

    handed = dataclasses.replace(job, payload=payload)
    with contextlib.closing(executor.outcomes(handed, missing)) as outcomes:
        for number, outcome in outcomes:
            given = payloads.pop(number)
            if outcome.foreign:
                raise ValueError(
                    f"a worker has another installation: {outcome.foreign}. Its bits may "
                    "differ: was something installed meanwhile? The same call begins anew."
                )
            if outcome.failure:
                failures[number] = outcome.failure
            else:
                store.write(number, given, outcome.content)
            done += 1
            progress(words(done), done / job.count)
    return Completion(dict(sorted(failures.items())), distrusted)


def results(job: Job, store: Store) -> Iterator[bytes | None]:
    """All units' results in their order, each checked as it is read.

    Args:
        job: The job.
        store: Where they are kept.

    Yields:
        A result; None where there is none.

    Raises:
        ValueError: If one was damaged since it was written.
    """
    for number in range(job.count):
        yield result(job, store, number)


def result(job: Job, store: Store, number: int) -> bytes | None:
    """A unit's result, checked as it is read.

    Args:
        job: The job.
        store: Where it is kept.
        number: The unit's number.

    Returns:
        The result; None where there is none.

    Raises:
        ValueError: If it was damaged since it was written.
    """
    try:
        return store.read(number, job.payload(number))
    except ValueError as error:
        raise ValueError(
            f"`--out`: record {number} in {store.folder} is {error}, since it was computed. "
            "The same call computes it anew; check the disk."
        ) from None


def _missing(
    job: Job, store: Store, progress: Progress
) -> tuple[Sequence[int], tuple[Distrusted, ...]]:
    """Units that the store hasn't, and what it has in their place."""
    missing, distrusted = [], []
    for number in range(job.count):
        if not store.has(number):  # Nothing to hold its inputs against.
            missing.append(number)
            continue
        try:
            store.read(number, job.payload(number))
        except ValueError as error:
            distrusted.append(Distrusted(store.name(number), str(error)))
            store.drop(number)
            missing.append(number)
        if number % 64 == 0:
            progress("checking what is kept", number / job.count)
    return missing, tuple(distrusted)
