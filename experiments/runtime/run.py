"""A job, run: what a store has isn't computed again, and what can't be is told."""

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence

from experiments.runtime.executors.executor import Executor
from experiments.runtime.store.store import Distrusted, Store
from scdpr_jax.numerics.progress import SILENT, Progress


def run(
    store: Store,
    executor: Executor,
    *,
    words: Callable[[int], str] = lambda done: f"{done:,} units",
    progress: Progress = SILENT,
) -> Mapping[int, str]:
    """Compute every unit that a store hasn't.

    Args:
        store: Where results are kept, and what of.
        executor: Who computes them.
        words: What is done, in words, when some units are.
        progress: Told what is being done and which share of it is done.

    Returns:
        Why units have no result, by their number; none of it is in the store.

    Raises:
        ValueError: If who computes can't be reached, or has another installation.
    """
    job = store.job
    missing = _missing(store, progress.part(0.0, 0.02))
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
    return dict(sorted(failures.items()))


def require_all(
    store: Store, failures: Mapping[int, str], *, name: str, place: Callable[[int], str]
) -> None:
    """Refuse to go on without some units' results.

    Args:
        store: Where the others are kept.
        failures: Why units have none, as `run` tells it.
        name: What the units are, such as "parts of the sweep".
        place: Which one a number is, in words.

    Raises:
        FloatingPointError: If there are any; the others are kept.
    """
    if failures:
        number, reason = next(iter(failures.items()))
        raise FloatingPointError(
            f"{len(failures)} of {store.job.count} {name} couldn't be computed, the first one "
            f"{place(number)}: {reason}. The others are kept: the same call tries these again."
        )


def results(store: Store) -> Iterator[bytes | None]:
    """All units' results in their order, each checked as it is read.

    Args:
        store: Where they are kept.

    Yields:
        A result; None where there is none.

    Raises:
        ValueError: If one was damaged since it was written.
    """
    for number in range(store.job.count):
        yield result(store, number)


def result(store: Store, number: int) -> bytes | None:
    """A unit's result, checked as it is read.

    Args:
        store: Where it is kept.
        number: The unit's number.

    Returns:
        The result; None where there is none.

    Raises:
        ValueError: If it was damaged since it was written.
    """
    try:
        return store.read(number, store.job.payload(number))
    except ValueError as error:
        raise ValueError(
            f"`--out`: record {number} in {store.folder} is {error}, since it was computed. "
            "The same call computes it anew; check the disk."
        ) from None


def _missing(store: Store, progress: Progress) -> Sequence[int]:
    """Units that the store hasn't; what it has in their place is told, and dropped."""
    missing, count = [], store.job.count
    for number in range(count):
        if not store.has(number):  # Nothing to hold its inputs against.
            missing.append(number)
            continue
        try:
            store.read(number, store.job.payload(number))
        except ValueError as error:
            store.distrusted(Distrusted(store.name(number), str(error)))
            store.drop(number)
            missing.append(number)
        if number % 64 == 0:
            progress("checking what is kept", number / count)
    return missing
