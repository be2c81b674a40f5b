"""`scdpr benchmark`: error beside speed, for this engine and its peers."""

import pathlib
from typing import Annotated, Literal

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, open_call, suggest, wrote
from experiments.verbs.exit_status import DONE
from experiments.verbs.places import try_out

Row = Literal[
    "forward-linear",
    "forward-nonlinear",
    "jacobian-linear",
    "jacobian-nonlinear",
    "cores",
    "fit",
    "frequencies",
    "cold-start",
]


def benchmark(
    out: pathlib.Path,
    only: Annotated[tuple[Row, ...], tyro.conf.arg(metavar="[ROW …]")] = (),
    repeats: int = 5,
    largest_batch: int = 4096,
) -> int:
    """Measure this engine beside diffrax, scipy, CasADi and MuJoCo on one problem.

    Give it a quiet machine, for a quarter of an hour or more; most of it is compilation. What
    isn't run stands in the table with its reason.

    Args:
        out: Folder for performance.md and performance.json.
        only: Rows to measure: forward-linear, forward-nonlinear, jacobian-linear,
            jacobian-nonlinear, cores, fit, frequencies, cold-start; default: all of them.
        repeats: Times that a median is of.
        largest_batch: Largest batch of runs, to try it out.
    """
    if repeats < 1 or largest_batch < 1:
        raise ValueError(
            "`--repeats` and `--largest-batch` must be 1 or more [1], got "
            f"{repeats} and {largest_batch}. Leave them out for 5 and 4096."
        )
    try_out(out / "performance.md")
    set_up()
    import jax

    from experiments.benchmarks import report
    from experiments.benchmarks.line import Settings
    from experiments.benchmarks.rows import ROWS
    from experiments.page.console_text import print_table
    from experiments.page.table import Table

    settings = Settings(repeats, largest_batch)
    chosen = [(name, measure) for name, measure in ROWS if not only or name in only]
    on = report.machine()
    lines = []
    with shown_progress(ERRORS, "benchmark") as progress:
        for done, (name, measure) in enumerate(chosen):
            progress(name, done / len(chosen))
            for line in measure(settings):
                lines.append(line)
                progress(f"{name}: {line.contender}, {line.batch:,}", done / len(chosen))
            # What is measured isn't lost with what comes after it.
            written = report.write(out, lines, on, settings)
            # Every program keeps some hundred maps of memory, and a process has 65,530.
            jax.clear_caches()
    rows = tuple(report.cells(line) for line in lines)
    print_table(OUT, Table("", report.HEADER, rows, words=(0, 1, 8), spare=((8,), (5,), (6,))))
    wrote(*written)
    suggest(open_call(out / "performance.md"))
    return DONE
