"""`scdpr check`: the log doctor."""

import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

from experiments.verbs.console import OUT, Folder, complain, pasted, say, suggest, wrote
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from experiments.verbs.places import require_outside, results_of, try_out

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
    from identification.campaign.faults import grouped
    from identification.doctor import examine, write_findings
    from identification.doctor.findings import from_fault
    from identification.doctor.mend import mend as write_mended

    if mend is not None:
        require_outside(mend, campaign)
        try_out(mend / "campaign.toml", name="--mend")
    if json is not None:
        try_out(json, name="--json")
    read = check_campaign(campaign)
    findings = () if read.campaign is None else examine(read.campaign)
    _print_runs(read.runs)
    for line in grouped((note.file, "", note.text) for note in read.notes):
        say(f"note: {line}")
    contradictions = [each for each in findings if each.severity != "note"]
    for each in (*(each for each in findings if each.severity == "note"), *contradictions):
        say(f"{each.severity}: {each}")
    if json is not None:
        write_findings((*map(from_fault, read.faults), *findings), json)
        wrote(json)
    if read.faults:
        complain(f"scdpr check: {CampaignError(campaign, read.faults)}")
        return BAD_INPUT
    say(f"{len(read.runs)} runs, {_number(len(contradictions))}.")
    if mend is not None:
        for each in write_mended(read.campaign, mend):
            say(f"mended: {each.id} in {len(each.runs)} runs")
        wrote(mend)
        suggest(f"scdpr check {pasted(mend)}")
    elif contradictions:
        mended = results_of(campaign).with_name(f"{campaign.resolve().name}-mended")
        suggest(f"scdpr check {pasted(campaign)} --mend {pasted(mended)}")
    else:
        suggest(f"scdpr calibrate {pasted(campaign)} --out {pasted(results_of(campaign))}")
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
        if run.kind is None:
            rows.append((run.name, "can't be read", "–", "–", "–", "–"))
            continue
        rows.append(
            (
                run.name,
                run.kind,
                f"{run.pretension:g} N",
                f"{run.duration:g} s",
                str(run.rows),
                str(run.camera_rows),
            )
        )
    header = ("run", "kind", "pretension", "duration", "rows", "frames")
    if rows:
        print_table(OUT, Table("", header, tuple(rows), words=(0, 1), spare=((4,), (5,))))
