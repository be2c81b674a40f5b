"""Plans of many legs: what is done is kept, and a stopped call goes on where it was."""

import pathlib
from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import numpy as np

from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.run import require_all, results, run
from experiments.runtime.store.store import Distrusted, Store, claimed
from experiments.studies.legs.unit import LEGS, parcel, planned_of
from scdpr_jax.command.controller import PD
from scdpr_jax.numerics.files import settle, write_whole
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.provenance import UNKNOWN, Provenance, of_no_day
from scdpr_jax.robot.parameters import Robot
from tuning.plan.legs_file import expectations_table
from tuning.plan.planning import Wanted

UNFINISHED = ".legs.unfinished"
"""Folder of what is done, while not everything is."""


class Legs(NamedTuple):
    """What came of a list of legs."""

    table: pathlib.Path
    """What is expected of each."""
    longer: int
    """How many take longer than asked for."""
    plain: int
    """How many are the plain profile."""


def write_legs(
    robot: Robot,
    controller: PD,
    legs: Sequence[Wanted],
    out: pathlib.Path,
    *,
    executor: Executor,
    marked: bool = False,
    provenance: Provenance = UNKNOWN,
    unit: int = LEGS,
    distrusted: Callable[[Distrusted], None] = lambda each: None,
    progress: Progress = SILENT,
) -> Legs:
    """Plan legs, a file each, with a table of what is expected of them.

    Args:
        robot: The fitted robot, with exact friction.
        controller: The PD controller that it will run under.
        legs: What is asked for.
        out: The folder.
        executor: Who computes.
        marked: Whether it is for a robot whose fit has failed.
        provenance: Where the tuning comes from.
        unit: Legs that are planned, kept and lost together.
        distrusted: Told what isn't used of what an earlier call has left.
        progress: Told what is being done and which share of it is done.

    Returns:
        What came of them.

    Raises:
        ValueError: If another call's parts are in its place, or another process is at it.
        FloatingPointError: If some legs can't be planned; the others are kept.
        OSError: If the place can't be written to.
    """
    made = provenance
    if made != UNKNOWN:
        made = of_no_day(provenance.campaign, provenance.source)
    context = parcel(robot, controller, legs, unit=unit, marked=marked, provenance=made)
    count = -(-len(legs) // unit)
    job = Job("legs", context, count, executor.installation)
    leaves = [np.asarray(leaf).tolist() for leaf in jax.tree.leaves((robot, controller))]
    inputs = {"legs": [(*own.start, *own.end, own.time, own.slope) for own in legs]}
    about = {**inputs, "robot": leaves}
    with claimed(out / UNFINISHED, job, about, distrusted) as store:
        failures = run(
            store,
            executor,
            words=lambda done: f"{min(done * unit, len(legs))} of {len(legs)} legs",
            progress=progress,
        )
        require_all(
            store,
            failures,
            name="parts of the legs",
            place=lambda number: f"from leg {number * unit + 1} on",
        )
        written = _written(store, out, len(legs))
        settle(out)
        store.remove()
    return written


def _written(store: Store, out: pathlib.Path, count: int) -> Legs:
    """The plans as files, and their table."""
    width = max(4, len(str(count)))
    names: list[str] = []
    rows: list[Sequence[str]] = []
    longer = plain = 0
    for content in results(store):
        made = planned_of(content or b"")
        for text in made.tables:
            names.append(f"plan-{len(names) + 1:0{width}d}.csv")
            write_whole(out / names[-1], text)
        rows += made.expectations
        longer, plain = longer + made.longer, plain + made.plain
    table = out / "legs.csv"
    write_whole(table, expectations_table(names, rows))
    return Legs(table, longer, plain)
