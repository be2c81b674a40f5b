"""`scdpr identify`: a campaign's parameters, or those of many."""

import os
import pathlib
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import (
    ERRORS,
    OUT,
    pasted,
    say,
    suggest,
    tell_distrusted,
    wrote,
)
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from experiments.verbs.places import require_outside, try_out

if TYPE_CHECKING:
    from experiments.studies.campaigns.identified import Question
    from experiments.studies.campaigns.places import Place

Asked = dict[str, Any]
"""The options that say what is asked of a campaign, by name."""
MOST_TOLD = 12
"""Failures that are told; the tables have them all."""


def identify(
    campaigns: Annotated[tuple[pathlib.Path, ...], tyro.conf.Positional],
    /,
    out: pathlib.Path,
    skip_bad_runs: bool = False,
    free: tuple[str, ...] = (),
    hold_out: tuple[str, ...] = (),
    measured: tuple[str, ...] = (),
    camera_drifts: bool = False,
    profile: bool = False,
    leave_out: bool = False,
    posterior: bool = False,
    accept: tuple[str, ...] = (),
    cores: int | None = None,
    cluster: str | None = None,
    certificates: pathlib.Path | None = None,
) -> int:
    """Estimate the robot's parameters from all runs of a campaign, or of each of several.

    Several campaigns, or a folder of them, become one table, campaigns.csv and campaigns.nc,
    with the reason where one fails. A call that was stopped goes on where it was: give it
    again.

    Args:
        campaigns: Folder of the campaign, format 1; several of them, or a folder of them.
        out: Folder for parameters.json; of several campaigns, for the tables and a folder each.
        skip_bad_runs: Go on without runs that have faults, and say which.
        free: Quantities to estimate; default: friction, drive inertia and damping, and
            the effective pretension of each setting, and where these leave more than noise
            those of the model that explains the rest best.
        hold_out: Runs to predict instead of fitting them.
        measured: What was measured otherwise, "NAME = VALUE +- STANDARD ERROR [at PLACE]":
            a quantity, which is then free; a breakaway_voltage at a pretension; a
            natural_frequency at a pretension and a height, as in "natural_frequency =
            3.2 Hz +- 0.02 Hz at 350 N, 0.55 m".
        camera_drifts: Whether the cameras' clocks may run faster or slower than the drives':
            a rate of each run is then estimated, too.
        profile: Trace the misfit along every quantity, too: whether it is bounded on both
            sides, on one, or on none. Takes as long again.
        leave_out: Fit anew without each run, too, to see which run moves what; otherwise
            that is a step of a fit, which is as good where the residuals are noise.
        posterior: Sample what the logs leave possible, too, by Hamiltonian Monte Carlo begun
            at the fit. Takes minutes; needs the extra `bayes`.
        accept: Contradictions of the log doctor to go on with, by their identifiers;
            parameters.json carries them.
        cores: Of several campaigns: processes of this machine to share them among; default:
            one for each core.
        cluster: Of several campaigns: a dask cluster to share them among, tcp://HOST:PORT or
            tls://HOST:PORT, or local:N for one of N workers on this machine. Needs the extra
            `cluster`.
        certificates: Folder with ca.pem, cert.pem and key.pem, for tls://.
    """
    # What is wrong with the input is said before anything heavy is imported.
    from experiments.runtime.executors.chosen import require_cluster
    from experiments.studies.campaigns.places import is_one, places
    from identification.campaign.abbreviation import free_quantities
    from identification.doctor.accepted import require_identifiers

    require_cluster(cluster, certificates, cores)
    require_identifiers(accept)
    for campaign in campaigns:
        require_outside(out, campaign)

    asked = {
        "free": free_quantities(free),
        "hold_out": hold_out,
        "measured": measured,
        "camera_drifts": camera_drifts,
        "profile": profile,
        "leave_out": leave_out,
        "posterior": posterior,
    }
    if not campaigns:
        raise ValueError(
            "no campaign was named, got none, expected a campaign's folder or more."
        )
    if not is_one(campaigns):
        return _many(
            places(campaigns),
            asked,
            out,
            accept=accept,
            skip_bad_runs=skip_bad_runs,
            shared=(cluster, certificates, cores or os.cpu_count() or 1),
        )
    if cluster is not None or cores is not None:
        raise ValueError(
            "`--cluster` and `--cores` share campaigns out, got one campaign, expected "
            "several. Leave them out: a fit uses this machine's cores as it is."
        )
    return _one(campaigns[0], asked, out, accept=accept, skip_bad_runs=skip_bad_runs)


def _one(
    campaign: pathlib.Path,
    asked: Asked,
    out: pathlib.Path,
    *,
    accept: tuple[str, ...],
    skip_bad_runs: bool,
) -> int:
    """A campaign by itself, with all that is to be said of it."""
    from experiments.verbs.log_doctor import examined
    from identification.campaign import read_campaign
    from identification.campaign.abbreviation import run_names

    try_out(out / "parameters.json")
    logs = read_campaign(campaign, skip_bad_runs=skip_bad_runs)
    held_out = run_names(logs, asked["hold_out"])
    read = examined(logs, accept, verb="identify")
    if read is None:
        return BAD_INPUT
    set_up()
    from experiments.reports import summary
    from experiments.studies.campaigns.identified import identified
    from experiments.studies.findings.findings import findings
    from identification.result.parameters_file import write_parameters
    from scdpr_jax.provenance import made_today

    question = _question(asked | {"hold_out": held_out})
    with shown_progress(ERRORS, "identify", campaign) as progress:
        fitted, traced, drawn = identified(read, question, progress=progress)
    write_parameters(
        out / "parameters.json",
        fitted,
        traced,
        drawn,
        read.accepted,
        made_today(read.name, read.source),
    )
    calibration = findings(fitted, campaign=read)
    summary.show(OUT, calibration, profiles=traced, posterior=drawn)
    summary.show_influence(OUT, calibration)
    for note in read.accepted:
        say(f"note: {note}")
    wrote(out / "parameters.json")
    if not fitted.fits:
        suggest(f"scdpr check {pasted(campaign)}")
        return FELL_SHORT
    suggest(f"scdpr frequencies {pasted(campaign)} --out {pasted(out)}")
    return DONE


def _many(
    campaigns: "tuple[Place, ...]",
    asked: Asked,
    out: pathlib.Path,
    *,
    accept: tuple[str, ...],
    skip_bad_runs: bool,
    shared: "tuple[str | None, pathlib.Path | None, int]",
) -> int:
    """Each of several campaigns, and one table of them."""
    from experiments.studies.campaigns.places import TABLES

    try_out(*(out / name for name in TABLES))
    set_up()
    from experiments.runtime.executors.chosen import chosen
    from experiments.studies.campaigns.run import identify_campaigns
    from scdpr_jax.numerics.files.harmless import printable

    question = _question(asked)
    cluster, certificates, cores = shared
    with (
        shown_progress(ERRORS, "identify many") as progress,
        chosen(cluster, certificates, min(cores, len(campaigns))) as executor,
    ):
        batch = identify_campaigns(
            campaigns,
            question,
            out,
            executor=executor,
            accept=accept,
            skip_bad_runs=skip_bad_runs,
            distrusted=tell_distrusted,
            progress=progress,
        )
    OUT.print(f"{len(campaigns) - len(batch.failed)} of {len(campaigns)} campaigns identified.")
    for name, reason in list(batch.failed.items())[:MOST_TOLD]:
        text = printable(f"{name}: {' '.join(reason.split())}")
        OUT.print(f"failed: {text}", markup=False, soft_wrap=True)
    if len(batch.failed) > MOST_TOLD:
        OUT.print(f"{len(batch.failed) - MOST_TOLD} more have failed: see the tables.")
    if batch.again:
        OUT.print(f"The same call tries {len(batch.again)} again, whose workers have failed.")
    wrote(*batch.tables)
    return FELL_SHORT if batch.failed else DONE


def _question(asked: Asked) -> "Question":
    """What is asked of a campaign, if it can be."""
    from experiments.studies.campaigns.identified import Question
    from identification.checks.posterior import require_numpyro

    question = Question(**asked)
    _ = question.options  # What can't be read of it is said before anything is computed.
    if question.posterior:
        require_numpyro()
    return question
