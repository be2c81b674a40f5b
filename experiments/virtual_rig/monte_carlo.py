"""A Monte Carlo of fits: many drawn robots, and how often their truth is found and covered."""

import csv
import io
import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel
from experiments.runtime.run import results, run
from experiments.runtime.store.store import Distrusted, claimed
from experiments.virtual_rig.recovery import DRAWN, Outcome
from experiments.virtual_rig.unit import outcome_of
from scdpr_jax.numerics.files import settle, write_whole
from scdpr_jax.numerics.progress import SILENT, Progress

COLUMNS = ("seed", "ended", "name", "truth", "error", "deviation", "covered", "reason")
"""Columns of the table: a row for each robot and quantity, or the reason for none."""


class Recoveries(NamedTuple):
    """What came of a Monte Carlo."""

    outcomes: Sequence[Outcome]
    """How campaigns went, by their seeds."""
    failed: Mapping[int, str]
    """Why there is no estimate, by seed: the same call tries these again."""

    def summary(self) -> list[str]:
        """How often the truth was found and covered, a line each."""
        right = [one for one in self.outcomes if one.right]
        lines = [f"right minimum: {len(right)} of {len(self.outcomes) + len(self.failed)}"]
        for name in DRAWN:
            covered = sum(one.covered[name] for one in right)
            lines.append(f"{name}: 95 % intervals hold the truth in {covered} of {len(right)}")
        return lines


def monte_carlo(
    seeds: range,
    out: pathlib.Path,
    *,
    executor: Executor,
    distrusted: Callable[[Distrusted], None] = lambda each: None,
    progress: Progress = SILENT,
) -> Recoveries:
    """Estimate drawn robots, each by itself, and put how they went into one table.

    While it isn't done, outcomes are kept in a folder beside the table; the same call goes on
    from there, by whatever executor, and ends with the same bytes.

    Args:
        seeds: Seeds of the robots, one after the other.
        out: The table, replaced if it exists.
        executor: Who computes.
        distrusted: Told what isn't used of what an earlier call has left.
        progress: Told what is being done and which share of it is done.

    Returns:
        What came of it.

    Raises:
        ValueError: If another call's parts are in its place, or another process is at it.
        OSError: If the place can't be written to.
    """
    facts = {"first": seeds.start}
    job = Job("recovery", Parcel(facts), len(seeds), executor.installation)
    folder = out.with_name(f".{out.name}.unfinished")
    with claimed(folder, job, facts, distrusted) as store:
        failures = run(
            store,
            executor,
            words=lambda done: f"{done:,} of {job.count:,} campaigns",
            progress=progress,
        )
        found = [outcome_of(content) for content in results(store) if content is not None]
        failed = {seeds[number]: reason for number, reason in failures.items()}
        made = Recoveries(found, failed)
        write_whole(out, _table(made))
        settle(out.parent)
        if not failed:
            store.remove()
    return made


def _table(made: Recoveries) -> str:
    rows = [
        (one.seed, one.ended, name, one.truth[name], one.error[name], one.deviation[name],
         one.covered[name], "")
        for one in made.outcomes
        for name in one.error
    ]  # fmt: skip
    rows += [(seed, *[""] * 6, " ".join(why.split())) for seed, why in made.failed.items()]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(sorted(rows, key=lambda row: row[0]))
    return text.getvalue()
