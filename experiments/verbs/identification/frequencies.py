"""`scdpr frequencies`: the frequency of every knock."""

import pathlib

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, pasted, say, suggest, wrote
from experiments.verbs.exit_status import BAD_INPUT, DONE
from experiments.verbs.places import require_outside, try_out


def frequencies(
    campaign: Folder,
    /,
    out: pathlib.Path,
    skip_bad_runs: bool = False,
    accept: tuple[str, ...] = (),
) -> int:
    """Find natural frequency and damping of every knock.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for frequencies.csv.
        skip_bad_runs: Go on without runs that have faults, and say which.
        accept: Contradictions of the log doctor to go on with, by their identifiers.
    """
    # What is wrong with the input is said before anything heavy is imported.
    from experiments.verbs.log_doctor import examined
    from identification.campaign import read_campaign

    require_outside(out, campaign)
    try_out(out / "frequencies.csv")
    read = examined(
        read_campaign(campaign, skip_bad_runs=skip_bad_runs), accept, verb="frequencies"
    )
    if read is None:
        return BAD_INPUT
    set_up()
    from experiments.reports import summary
    from experiments.studies.findings.plausibility import ringing_doubts
    from identification.fit.unknowns.options import FitOptions
    from identification.knocks.frequency_map import frequency_map, write_frequencies
    from scdpr_jax.provenance import made_today

    with shown_progress(ERRORS, "frequencies") as progress:
        progress("ring-downs", 0.0)
        knocks = frequency_map(read)
    made = made_today(read.name, read.source)
    write_frequencies(knocks, out / "frequencies.csv", provenance=made)
    summary.show_frequencies(OUT, knocks)
    for note in (*read.accepted, *ringing_doubts(knocks, FitOptions().prior(read))):
        say(f"note: {note}")
    wrote(out / "frequencies.csv")
    parameters = out / "parameters.json"
    if not parameters.exists():
        suggest(f"scdpr identify {pasted(campaign)} --out {pasted(out)}")
    suggest(
        f"scdpr tune --parameters {pasted(parameters)} --frequencies "
        f"{pasted(out / 'frequencies.csv')} --out {pasted(out)}"
    )
    return DONE
