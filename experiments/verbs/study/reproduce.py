"""`scdpr reproduce`: the paper's tables and figures, and the verdicts on them."""

import pathlib
from typing import Annotated

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, open_call, say, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out


def reproduce(
    names: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[NAME …]")
    ] = (),
    /,
    out: pathlib.Path = pathlib.Path("reproduction"),
    png: bool = False,
) -> int:
    """Compute what the paper prints, beside it, with a verdict on every number.

    Args:
        names: What to reproduce, such as fig12 or table2; default: everything.
        out: Folder for report.html and claims.csv.
        png: Write every figure as a PNG file of its own, too.
    """
    try_out(out / "report.html")
    set_up()
    from experiments.paper import report
    from experiments.paper.catalogue import chosen

    sections = chosen(names)
    with shown_progress(ERRORS, "reproduce") as progress:
        computing = progress.part(0.0, 0.98)
        if png:
            parts = report.reproduce(sections, computing, keep=report.png_files(out))
        else:
            parts = report.reproduce(sections, computing)
        progress("report", 0.98)
        written = report.write(parts, out)
    for line in report.told(parts):
        say(line)
    fallen = any(not each.stands for part in parts for each in part.judged)
    wrote(*written)
    suggest(open_call(out / "report.html"))
    return FELL_SHORT if fallen else DONE
