"""From a campaign to its parameters, frequencies, controller and report."""

import concurrent.futures
import dataclasses
import pathlib
from collections.abc import Callable, Sequence

import numpy as np

from experiments.files.parameters_file import write_parameters
from experiments.reports.report import write_report
from experiments.runtime import stage
from identification.campaign import Campaign
from identification.checks.selection import select
from identification.fit.unknowns.measured import Measured
from identification.knocks.frequency_map import FrequencyMap, frequency_map, write_frequencies
from identification.result.estimate import Estimate, estimate
from scdpr_jax.robot.prototype import consistent
from tuning.export import write_exports
from tuning.gains.optimise import LEG_TIMES, Effort
from tuning.gains.tune import prepare, tune
from tuning.result.document import write_tuning
from tuning.result.types import Tuning

Progress = Callable[[str, float], None]


@dataclasses.dataclass(frozen=True, eq=False)
class Calibration:
    """Everything that a campaign gives."""

    campaign: Campaign
    """The logged runs."""
    estimate: Estimate
    """The robot's parameters."""
    frequencies: FrequencyMap | None
    """Natural frequencies; None if no knock gives one."""
    tuning: Tuning
    """Gains and shapers."""
    notes: tuple[str, ...]
    """What a reader should know besides."""


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
    progress: Progress = lambda doing, share: None,
) -> Calibration:
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
        progress: Told what is being done and which share of it is done.

    Returns:
        The calibration.

    Raises:
        ValueError: If the campaign doesn't allow a fit.
        FloatingPointError: If a run's simulation isn't finite.
    """
    names = held_out_by_default(campaign) if hold_out is None else tuple(hold_out)
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # What tuning compiles doesn't depend on the fit: it comes along on another core.
        compiled = aside.submit(prepare, consistent(), leg_times=leg_times, effort=effort)
        known = {
            "hold_out": names,
            "measured": measured,
            "clock_drifts": clock_drifts,
            "progress": stage(progress, 0.02, 0.7),
        }
        if free is None:
            found = select(campaign, **known)
        else:
            found = estimate(campaign, free=free, **known)
        compiled.result()
    progress("ring-downs", 0.7)
    notes = _notes(campaign, found)
    frequencies = None
    if any(run.kind == "pseudo_impulse" for run in campaign.runs):
        try:
            frequencies = frequency_map(campaign)
            notes += [f"{name}: {why}" for name, why in frequencies.unresolved]
        except ValueError as error:
            notes.append(f"No frequency map: {error}")
    tuned = tune(
        found,
        frequencies,
        leg_times=leg_times,
        effort=effort,
        progress=stage(progress, 0.75, 0.95),
    )
    return Calibration(campaign, found, frequencies, tuned, tuple(notes))


def write_calibration(
    calibration: Calibration, out: pathlib.Path, *, truth: dict[str, float] | None = None
) -> tuple[pathlib.Path, ...]:
    """Write everything that a calibration gives, each file whole or not at all.

    Args:
        calibration: The calibration.
        out: The folder.
        truth: True values by name, where they are known.

    Returns:
        The files, the report first.
    """
    report = out / "report.html"
    parameters = out / "parameters.json"
    written = [report, parameters]
    write_parameters(parameters, calibration.estimate)
    if calibration.frequencies is not None:
        frequencies = out / "frequencies.csv"
        write_frequencies(calibration.frequencies, frequencies)
        written.append(frequencies)
    written += write_tuned(out, calibration.tuning)
    write_report(
        report,
        title=f"Calibration of {calibration.campaign.name}",
        campaign=calibration.campaign,
        estimate=calibration.estimate,
        frequencies=calibration.frequencies,
        tuning=calibration.tuning,
        truth=truth,
        notes=list(calibration.notes),
    )
    return tuple(written)


def write_tuned(out: pathlib.Path, tuning: Tuning) -> tuple[pathlib.Path, ...]:
    """Write `tuning.json`, and beside it the tuning as other programs run it.

    Args:
        out: The folder; the other programs' files go into its `export`.
        tuning: The tuning.

    Returns:
        The files, `tuning.json` first.

    Raises:
        ValueError: If the tuning has no fitted robot, or no shaper.
    """
    own = out / "tuning.json"
    write_tuning(own, tuning)
    return (own, *write_exports(out / "export", tuning))


def _notes(campaign: Campaign, found: Estimate) -> list[str]:
    notes = [
        f"Left out: {name}. " + " ".join(str(fault) for fault in faults)
        for name, faults in campaign.skipped
    ]
    if found.fit.ended == "unfinished":
        notes.append(
            "The fit used up its iterations before it met its stopping rule: its standard "
            "errors may be too small."
        )
    return notes
