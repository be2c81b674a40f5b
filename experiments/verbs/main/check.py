"""`scdpr check`: the log doctor."""

from experiments.verbs.console import ERRORS, OUT, Folder, suggest
from experiments.verbs.exit_status import BAD_INPUT, DONE


def check(campaign: Folder, /) -> int:
    """Look through a campaign's logs: every fault with file, row, cause and remedy.

    Args:
        campaign: Folder of the campaign, format 1.
    """
    from experiments.page.console_text import print_table
    from experiments.page.table import Table
    from identification.campaign import CampaignError, check_campaign

    check_result = check_campaign(campaign)
    rows = []
    for run in check_result.runs:
        numbers = (run.pretension, run.duration, run.rows, run.camera_rows)
        force, duration, samples, frames = ("–" if n is None else f"{n:g}" for n in numbers)
        rows.append((run.name, run.kind or "–", f"{force} N", f"{duration} s", samples, frames))
    header = ("run", "kind", "pretension", "duration", "rows", "frames")
    print_table(OUT, Table("", header, tuple(rows), words=(0, 1)))
    for note in check_result.notes:
        OUT.print(f"note: {note}", markup=False)
    if check_result.faults:
        print(f"scdpr check: {CampaignError(campaign, check_result.faults)}", file=ERRORS.file)
        return BAD_INPUT
    OUT.print(f"{len(check_result.runs)} runs, no fault.")
    suggest(f"scdpr calibrate {campaign} --out DIR")
    return DONE
