"""`scdpr identify`: a campaign's parameters."""

import itertools
import pathlib
from typing import TYPE_CHECKING

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, pasted, say, suggest, wrote
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from experiments.verbs.places import require_folder, require_outside

if TYPE_CHECKING:
    from scdpr_jax.numerics.progress import Progress


def identify(
    campaign: Folder,
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
) -> int:
    """Estimate the robot's parameters from all runs of a campaign.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for parameters.json.
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
    """
    # What is wrong with the input is said before anything heavy is imported.
    from experiments.verbs.log_doctor import examined
    from identification.campaign import read_campaign
    from identification.campaign.abbreviation import free_quantities, run_names

    require_outside(out, campaign)
    require_folder(out)
    logs = read_campaign(campaign, skip_bad_runs=skip_bad_runs)
    freed, held_out = free_quantities(free), run_names(logs, hold_out)
    read = examined(logs, accept, verb="identify")
    if read is None:
        return BAD_INPUT
    set_up()
    from experiments.reports import summary
    from experiments.studies.findings.findings import findings
    from identification.checks.leave_out import without_each_run
    from identification.checks.posterior import posterior as sampled
    from identification.checks.posterior import require_numpyro
    from identification.checks.profile import profile as traced_profiles
    from identification.checks.selection import select
    from identification.fit.unknowns.measured_text import parse_measured
    from identification.fit.unknowns.options import DEFAULT_FREE, FitOptions
    from identification.result.estimation import estimate
    from identification.result.parameters_file import write_parameters
    from scdpr_jax.provenance import made_today

    if posterior:
        require_numpyro()
    options = FitOptions(
        free=freed or DEFAULT_FREE,
        hold_out=held_out,
        measured=tuple(map(parse_measured, measured)),
        clock_drifts=camera_drifts,
    )
    with shown_progress(ERRORS, "identify") as progress:
        fit, tracing, leaving, drawing = _parts(
            progress, profile=profile, leave_out=leave_out, posterior=posterior
        )
        fitted = (estimate if free else select)(read, options, progress=fit)
        if profile:
            tracing("profiles", 0.0)
        traced = traced_profiles(read, fitted) if profile else ()
        if leave_out:
            fitted = without_each_run(read, fitted, progress=leaving)
        drawn = sampled(read, fitted, progress=drawing) if posterior else None
    made, written = made_today(read.name, read.source), out / "parameters.json"
    write_parameters(written, fitted, traced, drawn, read.accepted, made)
    calibration = findings(fitted, campaign=read)
    summary.show(OUT, calibration, profiles=traced, posterior=drawn)
    summary.show_influence(OUT, calibration)
    for note in read.accepted:
        say(f"note: {note}")
    wrote(written)
    if not fitted.fits:
        suggest(f"scdpr check {pasted(campaign)}")
        return FELL_SHORT
    suggest(f"scdpr frequencies {pasted(campaign)} --out {pasted(out)}")
    return DONE


def _parts(
    progress: "Progress", *, profile: bool, leave_out: bool, posterior: bool
) -> "tuple[Progress, ...]":
    """Progress of the fit, its profiles, the fits without each run, and the draws."""
    # A profile takes as long as a fit, a fit without each run twice, draws ten times.
    costs = itertools.accumulate((1, 1 * profile, 2 * leave_out, 10 * posterior))
    ends = tuple(costs)
    shares = [0.0, *(end / ends[-1] for end in ends)]
    return tuple(progress.part(*pair) for pair in itertools.pairwise(shares))
