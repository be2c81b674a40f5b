"""`scdpr check`: the log doctor."""

from experiments.verbs.console import ERRORS, OUT, Folder, suggest
from experiments.verbs.exit_status import BAD_INPUT, DONE


def check(campaign: Folder, /) -> int:
    """Look through a campaign's logs: every fault with file, row, cause and remedy.

    Args:
        campaign: Folder of the campaign, format 1.
    """
    from rich.table import Table

    from identification.campaign import CampaignError, check_campaign

    found = check_campaign(campaign)
    table = Table("run", "kind", "pretension", "duration", "rows", "frames", box=None)
    for run in found.runs:
        numbers = (run.pretension, run.duration, run.rows, run.camera_rows)
        force, duration, rows, frames = ("–" if n is None else f"{n:g}" for n in numbers)
        table.add_row(run.name, run.kind or "–", f"{force} N", f"{duration} s", rows, frames)
    OUT.print(table)
    for note in found.notes:
        OUT.print(f"note: {note}", markup=False)
    if found.faults:
        print(f"scdpr check: {CampaignError(campaign, found.faults)}", file=ERRORS.file)
        return BAD_INPUT
    OUT.print(f"{len(found.runs)} runs, no fault.")
    suggest(f"scdpr calibrate {campaign} --out DIR")
    return DONE
