"""From a campaign to its parameters, frequencies, gains and shapers."""

import concurrent.futures
from collections.abc import Sequence

import numpy as np

from experiments.studies.findings import Findings, findings
from identification.campaign import Campaign
from identification.checks.selection import select
from identification.fit.unknowns.measured import Measured
from identification.fit.unknowns.options import DEFAULT_FREE, FitOptions
from identification.knocks.frequency_map import frequency_map
from identification.result.estimate import Estimate
from identification.result.estimation import estimate
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.prototype import consistent
from tuning.gains.optimise import LEG_TIMES, Effort
from tuning.gains.tune import prepare, tune


def held_out_by_default(campaign: Campaign) -> tuple[str, ...]:
    """The run to predict instead of fitting it: the manoeuvre that goes the furthest.

    Args:
        campaign: The campaign.

    Returns:
        Its name; nothing where fitting would be left without another moving run of the
        same pretension.
    """
    manoeuvres = [run for run in campaign.runs if run.kind == "manoeuvre"]
    if not manoeuvres:
        return ()
    furthest = max(manoeuvres, key=lambda run: np.ptp(np.sum(run.drive.angle, axis=1)))
    others = [
        run
        for run in campaign.runs
        if run is not furthest
        and run.kind in ("torque_step", "manoeuvre", "free")
        and run.pretension_label == furthest.pretension_label
    ]
    return (furthest.name,) if others else ()


def calibrate(
    campaign: Campaign,
    *,
    free: Sequence[str] | None = None,
    hold_out: Sequence[str] | None = None,
    measured: Sequence[Measured] = (),
    clock_drifts: bool = False,
    leg_times: tuple[float, ...] = LEG_TIMES,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    force: bool = False,
    progress: Progress = SILENT,
) -> Findings:
    """Parameters, frequencies, gains and shapers of a campaign.

    Args:
        campaign: The campaign.
        free: Names of the quantities to estimate; None for the usual ones, and where
            these leave more than noise those of the model that explains the rest best.
        hold_out: Names of the runs to predict instead of fitting them; None for
            `held_out_by_default`.
        measured: What was measured otherwise.
        clock_drifts: Whether the cameras' clocks may drift.
        leg_times: Times of a leg that the tuning is made for [s].
        effort: How much is spent on the tuning.
        force: Whether to tune even if the fit has failed.
        progress: Told what is being done and which share of it is done.

    Returns:
        What the calibration comes to.

    Raises:
        ValueError: If the campaign doesn't allow a fit.
        FloatingPointError: If a run's simulation isn't finite.
    """
    names = held_out_by_default(campaign) if hold_out is None else tuple(hold_out)
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # What tuning compiles doesn't depend on the fit: it comes along on another core.
        compiled = aside.submit(prepare, consistent(), leg_times=leg_times)
        options = FitOptions(
            free=DEFAULT_FREE if free is None else free,
            hold_out=names,
            measured=measured,
            clock_drifts=clock_drifts,
        )
        fit = select if free is None else estimate
        fitted = fit(campaign, options, progress=progress.part(0.02, 0.7))
        compiled.result()
    progress("ring-downs", 0.7)
    notes = _notes(campaign, fitted)
    frequencies = None
    if any(run.kind == "pseudo_impulse" for run in campaign.runs):
        try:
            frequencies = frequency_map(campaign)
            notes += [f"{name}: {why}" for name, why in frequencies.unresolved]
        except ValueError as error:
            notes.append(f"No frequency map: {error}")
    tuned = None
    if fitted.fits or force:
        tuned = tune(
            fitted,
            frequencies,
            leg_times=leg_times,
            effort=effort,
            force=force,
            progress=progress.part(0.75, 0.95),
        )
    return findings(
        fitted,
        campaign=campaign,
        frequencies=frequencies,
        tuning=tuned,
        notes=tuple(notes),
    )


def _notes(campaign: Campaign, fitted: Estimate) -> list[str]:
    notes = [
        f"Left out: {name}. " + " ".join(str(fault) for fault in faults)
        for name, faults in campaign.skipped
    ]
    notes += campaign.accepted
    if fitted.fit.ended == "unfinished":
        notes.append(
            "The fit used up its iterations before it met its stopping rule: its standard "
            "errors may be too small."
        )
    return notes
