"""`scdpr import`: logs of any make as runs of format 1."""

import pathlib
from typing import Annotated

import tyro

from experiments.runtime import shown_progress
from experiments.verbs.console import ERRORS, pasted, say, suggest, wrote
from experiments.verbs.exit_status import DONE
from experiments.verbs.places import results_of, try_out


def import_(
    files: Annotated[tuple[pathlib.Path, ...], tyro.conf.Positional],
    /,
    into: pathlib.Path | None = None,
    propose: pathlib.Path | None = None,
) -> int:
    """Write runs of format 1 from logs of any make, as a mapping says.

    `scdpr import MAPPING.toml --into CAMPAIGN` imports; `scdpr import LOG … --propose
    MAPPING.toml` looks at logs and writes the mapping that it would use. Exits 2 where
    anything is missing or wrong, and nothing is written then.

    Args:
        files: The mapping; or, with `--propose`, the logs: CSV and its relatives, TDMS, MAT.
        into: Folder of the campaign; made where there is none. One that has a campaign.toml
            keeps it, and its runs.
        propose: The mapping to write. With `--into`, what that campaign states counts.
    """
    if not files or (into is None and propose is None):
        raise ValueError(
            "nothing to do, got neither `--into` nor `--propose`, or no file, expected "
            "`scdpr import MAPPING.toml --into CAMPAIGN` or `scdpr import LOG … --propose "
            "MAPPING.toml`."
        )
    if propose is not None:
        try_out(propose)
        return _propose(files, propose, into)
    if len(files) > 1:
        raise ValueError(
            f"one mapping at a time, got {len(files)} files, expected one TOML file. Logs are "
            "named in the mapping; `--propose MAPPING.toml` writes one."
        )
    try_out(into / "campaign.toml")
    return _import(files[0], into)


def _import(mapping: pathlib.Path, into: pathlib.Path) -> int:
    from identification.bring.campaign_import import import_campaign

    with shown_progress(ERRORS, "import") as progress:
        progress("reads the logs", 0.0)
        campaign = import_campaign(mapping, into)
    for run in campaign.runs:
        frames = 0 if run.camera is None else len(run.camera.time)
        say(
            f"{run.name}: {run.kind}, {len(run.drive.time)} samples, {frames} frames",
        )
    _ask_the_doctor(into)
    wrote(*(into / run.name for run in campaign.runs))
    suggest(
        f"scdpr check {pasted(into)}",
        f"scdpr calibrate {pasted(into)} --out {pasted(results_of(into))}",
    )
    return DONE


def _ask_the_doctor(into: pathlib.Path) -> None:
    """What the sensors of the whole campaign say, and what of it a mapping can change."""
    from identification.bring.changes import mapping_changes
    from identification.campaign import check_campaign
    from identification.doctor import examine

    read = check_campaign(into)
    findings = () if read.campaign is None else examine(read.campaign)
    for fault in read.faults:
        say(f"fault: {fault}")
    for note in read.notes:
        say(f"note: {note}")
    for finding in findings:
        say(f"{finding.severity}: {finding}")
    changes = mapping_changes((f.id, f.runs, f.mend) for f in findings if f.mend is not None)
    if changes:
        say("In the mapping, these would put it right; nothing of it is done:")
    for line in changes:
        say(f"  {line}")


def _propose(
    logs: tuple[pathlib.Path, ...], mapping: pathlib.Path, into: pathlib.Path | None
) -> int:
    from identification.bring.proposal.propose import propose_mapping

    proposal = propose_mapping(logs, mapping, into=into)
    for line in proposal.told:
        say(line)
    wrote(mapping)
    campaign = mapping.with_name("campaign") if into is None else into
    suggest(
        f"read {mapping}, correct it",
        f"scdpr import {pasted(mapping)} --into {pasted(campaign)}",
    )
    return DONE
