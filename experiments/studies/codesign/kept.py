"""A co-design's searches as units: what is done is kept until the co-design is written."""

import contextlib
import pathlib
from collections.abc import Callable, Iterator, Sequence

from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.run import require_all, results, run
from experiments.runtime.store.store import Distrusted, Store, claimed
from experiments.studies.codesign.unit import designed_of, parcel, payload
from scdpr_jax.numerics.progress import Progress
from tuning.codesign.designed import Designed
from tuning.codesign.search import Designer, Search, Start


@contextlib.contextmanager
def kept_designs(
    out: pathlib.Path,
    executor: Executor,
    *,
    distrusted: Callable[[Distrusted], None] = lambda each: None,
) -> Iterator[Designer]:
    """Who searches for the designs of a co-design, and keeps them on the way.

    A call that was stopped goes on where it was, at whatever moment, by whatever executor, and
    ends with the same bits. What is kept is removed where the block ends without an error: its
    results are written by then.

    Args:
        out: Folder of the results; each round of searches has a folder of its own in it.
        executor: Who computes.
        distrusted: Told what isn't used of what an earlier call has left.

    Yields:
        The designer. It raises ValueError if another call's searches are in their place, or
        another process is at it; FloatingPointError if one of them fails.
    """
    with contextlib.ExitStack() as stack:
        stores: list[Store] = []

        def designer(
            search: Search, starts: Sequence[Start], progress: Progress
        ) -> Sequence[Designed]:
            job = _job(search, starts, executor)
            inputs = {"starts": [[one.move_time, *one.point.tolist()] for one in starts]}
            folder = out / f".codesign-{len(stores) + 1}.unfinished"
            store = stack.enter_context(claimed(folder, job, inputs, distrusted))
            stores.append(store)
            failures = run(
                store,
                executor,
                words=lambda done: f"co-design: {done} of {job.count} searches",
                progress=progress,
            )
            require_all(
                store,
                failures,
                name="searches of the co-design",
                place=lambda number: f"number {number + 1}",
            )
            return [designed_of(content or b"") for content in results(store)]

        yield designer
        for store in stores:
            store.remove()


def _job(search: Search, starts: Sequence[Start], executor: Executor) -> Job:
    return Job(
        "codesign",
        parcel(search),
        len(starts),
        executor.installation,
        lambda number: payload(starts[number]),
    )
