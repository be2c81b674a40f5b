"""Many campaigns, identified: what is done is kept, and every failure is a row."""

import dataclasses
import pathlib
from collections.abc import Callable, Mapping, Sequence

from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel
from experiments.runtime.run import result, run
from experiments.runtime.store.store import Distrusted, Store, claimed
from experiments.studies.campaigns.files import packed_files
from experiments.studies.campaigns.identified import Question
from experiments.studies.campaigns.places import TABLES, Place
from experiments.studies.campaigns.table import Row, rows, write_csv, write_netcdf
from experiments.studies.campaigns.unit import Answer, answer_of
from scdpr_jax.numerics.files import settle, write_whole
from scdpr_jax.numerics.progress import SILENT, Progress

UNFINISHED = ".campaigns.unfinished"
"""Folder of what is done, while not everything is."""


@dataclasses.dataclass(frozen=True)
class Batch:
    """What came of many campaigns."""

    tables: tuple[pathlib.Path, ...]
    """The tables that were written."""
    failed: dict[str, str]
    """Why campaigns have no parameters that can be used, by name."""
    again: tuple[str, ...]
    """Of these, those whose worker failed and not they: the same call tries them again."""


def identify_campaigns(
    campaigns: Sequence[Place],
    question: Question,
    out: pathlib.Path,
    *,
    executor: Executor,
    accept: Sequence[str] = (),
    skip_bad_runs: bool = False,
    distrusted: Callable[[Distrusted], None] = lambda each: None,
    progress: Progress = SILENT,
) -> Batch:
    """Identify campaigns, each by itself, and put all in one table.

    While it isn't done, answers are kept in the folder; the same call goes on from there, at
    whatever moment it was stopped, by whatever executor, and ends with the same bytes.

    Args:
        campaigns: The campaigns.
        question: What is asked of each.
        out: Folder for the tables, and a folder with parameters.json for each campaign.
        executor: Who computes.
        accept: Contradictions of the log doctor to go on with.
        skip_bad_runs: Whether to go on without runs that have faults.
        distrusted: Told what isn't used of what an earlier call has left.
        progress: Told what is being done and which share of it is done.

    Returns:
        What came of it.

    Raises:
        ValueError: If another call's parts are in its place, or another process is at it.
        OSError: If the place can't be written to.
    """
    facts = {
        "names": [place.name for place in campaigns],
        "question": dataclasses.asdict(question),
        "accept": list(accept),
        "skip_bad_runs": skip_bad_runs,
    }
    job = Job(
        "identify",
        Parcel(facts),
        len(campaigns),
        executor.installation,
        lambda number: packed_files(campaigns[number].folder),
    )
    with claimed(out / UNFINISHED, job, facts, distrusted) as store:
        failures = run(
            store,
            executor,
            words=lambda done: f"{done:,} of {job.count:,} campaigns",
            progress=progress.part(0.0, 0.98),
        )
        progress("writing", 0.98)
        batch = _written(campaigns, store, failures, out)
        if not failures:
            store.remove()
    return batch


def _written(
    campaigns: Sequence[Place],
    store: Store,
    failures: Mapping[int, str],
    out: pathlib.Path,
) -> Batch:
    table: list[Row] = []
    failed: dict[str, str] = {}
    for number, place in enumerate(campaigns):
        content = result(store, number)
        answer = Answer("", failures[number]) if content is None else answer_of(content)
        parameters = out / place.name / "parameters.json"
        if answer.document:
            write_whole(parameters, answer.document)
        else:
            parameters.unlink(missing_ok=True)  # An earlier call's would pass for this one's.
        if answer.reason:
            failed[place.name] = answer.reason
        table += rows(place.name, answer)
    text, binary = (out / name for name in TABLES)
    write_csv(text, table)
    write_netcdf(binary, table, scratch=store.folder)
    settle(out)
    again = tuple(campaigns[number].name for number in failures)
    return Batch((text, binary), failed, again)
