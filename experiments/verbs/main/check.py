"""`scdpr check`: the log doctor."""

import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

from experiments.verbs.console import ERRORS, OUT, Folder, suggest, wrote
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from experiments.verbs.places import require_outside, try_out

if TYPE_CHECKING:
    from identification.campaign import RunSummary


def check(
    campaign: Folder,
    /,
    json: pathlib.Path | None = None,
    mend: pathlib.Path | None = None,
) -> int:
    """Look through a campaign's logs: every fault with file, row, cause and remedy.

    Exits 2 for a fault, 1 where two sensors contradict each other, else 0.

    Args:
        campaign: Folder of the campaign, format 1.
        json: File for the findings, as JSON.
        mend: Folder for a copy in which everything is put right that can be; the campaign
            itself stays as it is.
    """
    from identification.campaign import CampaignError, check_campaign
    from identification.doctor import examine, write_findings
    from identification.doctor.findings import from_fault
    from identification.doctor.mend import mend as write_mended

    if mend is not None:
        require_outside(mend, campaign)
        try_out(mend / "campaign.toml")
    if json is not None:
        try_out(json)
    read = check_campaign(campaign)
    findings = () if read.campaign is None else examine(read.campaign)
    _print_runs(read.runs)
    for told in (*read.notes, *(each for each in findings if each.severity == "note")):
        OUT.print(f"note: {told}", markup=False)
    contradictions = [each for each in findings if each.severity != "note"]
    for each in contradictions:
        OUT.print(f"{each.severity}: {each}", markup=False)
    if json is not None:
        write_findings((*map(from_fault, read.faults), *findings), json)
        wrote(json)
    if read.faults:
        print(f"scdpr check: {CampaignError(campaign, read.faults)}", file=ERRORS.file)
        return BAD_INPUT
    OUT.print(f"{len(read.runs)} runs, {_number(len(contradictions))}.")
    if mend is not None:
        for each in write_mended(read.campaign, mend):
            OUT.print(f"mended: {each.id} in {len(each.runs)} runs", markup=False)
        wrote(mend)
        suggest(f"scdpr check {mend}")
    elif contradictions:
        suggest(f"scdpr check {campaign} --mend OUT")
    else:
        suggest(f"scdpr calibrate {campaign} --out DIR")
    return FELL_SHORT if contradictions else DONE


def _number(contradictions: int) -> str:
    if not contradictions:
        return "no fault"
    return f"{contradictions} contradiction{'s' if contradictions > 1 else ''}"


def _print_runs(runs: "Sequence[RunSummary]") -> None:
    """One line a run."""
    from experiments.page.console_text import print_table
    from experiments.page.table import Table

    rows = []
    for run in runs:
        numbers = (run.pretension, run.duration, run.rows, run.camera_rows)
        force, duration, samples, frames = ("–" if n is None else f"{n:g}" for n in numbers)
        rows.append((run.name, run.kind or "–", f"{force} N", f"{duration} s", samples, frames))
    header = ("run", "kind", "pretension", "duration", "rows", "frames")
    print_table(OUT, Table("", header, tuple(rows), words=(0, 1)))
