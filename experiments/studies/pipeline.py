"""From a campaign to its parameters, frequencies, gains and shapers."""

import concurrent.futures
import contextlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from experiments.studies.findings.findings import Findings, findings
from experiments.studies.posterior import draws_of
from experiments.studies.rehearsal import rehearse
from identification.campaign import Campaign
from identification.checks.selection import select
from identification.fit.unknowns.measured import Measured
from identification.fit.unknowns.options import DEFAULT_FREE, FitOptions
from identification.knocks.frequency_map import FrequencyMap, frequency_map
from identification.result.estimate import Estimate
from identification.result.estimation import estimate
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from tuning.gains.manoeuvre import LEG_TIMES
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune


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
    fitted: Callable[[Estimate], None] = lambda estimate: None,
    processes: concurrent.futures.Executor | None = None,
    progress: Progress | bool = SILENT,
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
        leg_times: Times of a leg of the manoeuvre that is simulated with the tuning [s].
        effort: How much is spent on the tuning.
        force: Whether to tune even if the fit has failed.
        fitted: Told the estimate as soon as there is one, while gains are sought.
        processes: Who plans legs, and rehearses a first tuning.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        What the calibration comes to.

    Raises:
        ValueError: If the campaign doesn't allow a fit.
        FloatingPointError: If a run's simulation isn't finite.
    """
    progress = listening(progress)
    names = held_out_by_default(campaign) if hold_out is None else tuple(hold_out)
    with _aside() as aside:
        # Ring-downs don't depend on the fit: another core does them.
        rung = aside.submit(_frequencies, campaign)
        rehearsal = aside.submit(rehearse, processes, leg_times)
        options = FitOptions(
            free=DEFAULT_FREE if free is None else free,
            hold_out=names,
            measured=measured,
            clock_drifts=clock_drifts,
        )
        fit = select if free is None else estimate
        found = fit(campaign, options, progress=progress.part(0.02, 0.7))
        told = aside.submit(fitted, found)
        progress("ring-downs", 0.7)
        frequencies, unresolved = rung.result()
        tuned = None
        if found.fits or force:
            concurrent.futures.wait(rehearsal.result())
            tuned = tune(
                found,
                frequencies,
                draws=draws_of(found.fitted),
                leg_times=leg_times,
                effort=effort,
                force=force,
                processes=processes,
                progress=progress.part(0.75, 0.95),
            )
        told.result()
    return findings(
        found,
        campaign=campaign,
        frequencies=frequencies,
        tuning=tuned,
        notes=(*_notes(campaign, found), *unresolved),
    )


@contextlib.contextmanager
def _aside() -> Iterator[concurrent.futures.Executor]:
    """A few threads; what waits for them is dropped if something goes wrong."""
    pool = concurrent.futures.ThreadPoolExecutor(3)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _frequencies(campaign: Campaign) -> tuple[FrequencyMap | None, list[str]]:
    """The measured map, if there is one, and what is to be said of it."""
    if not any(run.kind == "pseudo_impulse" for run in campaign.runs):
        return None, []
    try:
        frequencies = frequency_map(campaign)
    except ValueError as error:
        return None, [f"No frequency map: {error}"]
    return frequencies, [f"{name}: {why}" for name, why in frequencies.unresolved]


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
