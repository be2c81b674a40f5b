"""The calibration's report: one HTML file that needs nothing else."""

import dataclasses
import inspect
import pathlib
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from experiments.figures.identification.correlation import correlation
from experiments.figures.identification.fit_overview import fit_overview
from experiments.figures.identification.frequency_map import (
    frequency_map,
    frequency_over_height,
)
from experiments.figures.identification.intervals import intervals, shown_name
from experiments.figures.identification.residuals import residuals
from experiments.figures.identification.ring_down import ring_down_figure
from experiments.figures.identification.run_comparison import run_comparison
from experiments.figures.robot_view import robot_view, shown_instants
from experiments.page.drawing import Draw, draw
from experiments.page.number_text import percent, plain
from experiments.page.page import Picture, Pictures, page, versions
from experiments.page.table import Table, table_of
from experiments.reports.drive_report import write_drive_report as write_drive_report
from experiments.reports.influence_tables import influence_tables
from experiments.reports.knock_table import knock_table_with_fft
from experiments.reports.model_tables import measured_tables, model_tables, moved_table
from experiments.reports.parameter_table import parameter_row
from experiments.reports.tuning_section import tuning_pictures, tuning_tables
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.influence import influence_sentences
from experiments.studies.findings.models import combination_sentences
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.predictions import Prediction
from experiments.studies.findings.tuning import TuningFindings
from identification.campaign.types import Campaign
from identification.fit.comparison import Comparison
from identification.fit.starts import Valley
from identification.judge.uncertainty import ParameterEstimate, covariance
from identification.result.estimate import Estimate
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.robot.quantities import value

RUNS_DRAWN = 8
"""Runs that are drawn one by one: more would make the page heavy without telling more."""


def write_report(
    path: pathlib.Path,
    findings: Findings,
    *,
    title: str,
    truth: dict[str, float] | None,
    pictures: "FitPictures | None" = None,
) -> None:
    """Write the report of a calibration, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        findings: What the calibration comes to; it has its campaign.
        title: Its title.
        truth: True values by name [SI], where they are known.
        pictures: The pictures of the fit, if they have been begun.

    Raises:
        OSError: If the place can't be written to.
    """
    campaign, estimate = findings.campaign, findings.estimate
    frequencies, tuning = findings.frequencies, findings.tuning
    if pictures is None:
        pictures = FitPictures(campaign, truth=truth)
        pictures.begin(estimate)
    picture, words = pictures.picture, findings.words
    _, left_out = runs_to_draw(estimate.comparisons)
    text = page(
        "report.html.j2",
        title=title,
        campaign=campaign,
        words=words,
        verdict=findings.verdict,
        found=words.found + _tuning_sentences(tuning),
        notes=findings.notes,
        rows=[parameter_row(parameter, truth=truth) for parameter in estimated(estimate)],
        fixed=[parameter_row(p) for p in estimate.parameters if p.status == "fixed"],
        with_truth=bool(truth),
        parameter_pictures=pictures.of_parameters,
        fit_pictures=pictures.of_fit,
        predictions=_predictions(findings.predictions),
        model_tables=(*measured_tables(findings.measured), *model_tables(estimate)),
        moved=moved_table(estimate.identifiability),
        combinations=combination_sentences(estimate.identifiability),
        influence_words=influence_sentences(findings.influence),
        influence_tables=influence_tables(estimate),
        knocks=None if frequencies is None else knock_table_with_fft(frequencies),
        map_pictures=[] if frequencies is None else list(_map_pictures(findings, picture)),
        tuning_tables=() if tuning is None else tuning_tables(tuning.tuning),
        tuning_pictures=(
            ()
            if tuning is None
            else tuning_pictures(tuning, robot=estimate.robot, picture=picture)
        ),
        runs=pictures.of_runs,
        not_drawn=[comparison.name for comparison in left_out],
        method=method_notes(),
        provenance=_provenance(campaign, estimate),
    )
    write_whole(pathlib.Path(path), text)


class FitPictures:
    """The report's pictures of the fit, which are drawn while gains are still sought."""

    def __init__(
        self, campaign: Campaign, *, truth: dict[str, float] | None = None, draw: Draw = draw
    ) -> None:
        """A report without a picture.

        Args:
            campaign: The campaign.
            truth: True values by name [SI], where they are known.
            draw: What draws the report's figures.
        """
        self._campaign, self._truth = campaign, truth
        self.picture = Pictures(draw=draw)
        self.of_parameters: list[Picture] = []
        self.of_fit: list[Picture] = []
        self.of_runs: list[dict[str, Any]] = []

    def begin(self, estimate: Estimate) -> None:
        """Have the pictures drawn.

        Args:
            estimate: The estimate that the report will be of.
        """
        drawn, _ = runs_to_draw(estimate.comparisons)
        self.of_runs = [_run(self._campaign, run, self.picture) for run in drawn]
        self.of_parameters = list(_parameter_pictures(estimate, self._truth, self.picture))
        self.of_fit = list(_fit_pictures(estimate, self.picture))


def _tuning_sentences(tuning: TuningFindings | None) -> tuple[str, ...]:
    return () if tuning is None else (*tuning.sentences, *tuning.between_the_cells)


def runs_to_draw(
    comparisons: Sequence[Comparison],
) -> tuple[tuple[Comparison, ...], tuple[Comparison, ...]]:
    """The runs that the report draws one by one, and those that it doesn't.

    Args:
        comparisons: All runs.

    Returns:
        Held-out runs and those with the worst residuals, in the order that they have; and
        the rest.
    """

    def worst(comparison: Comparison) -> float:
        return max((channel.chi_square for channel in comparison.channels), default=0.0)

    ranked = sorted(comparisons, key=lambda one: (not one.held_out, -worst(one)))
    chosen = {one.name for one in ranked[:RUNS_DRAWN]}
    return (
        tuple(one for one in comparisons if one.name in chosen),
        tuple(one for one in comparisons if one.name not in chosen),
    )


def method_notes() -> tuple[str, ...]:
    """How the uncertainty was computed, from where it is computed.

    Returns:
        Paragraphs in plain text.
    """
    docstring = inspect.getdoc(covariance) or ""
    paragraphs = docstring.split("\nArgs:")[0].strip().split("\n\n")
    return (
        "All runs are simulated from their commands with exact Coulomb friction, and the "
        "parameters minimise what is left between simulation and measurement, weighted with "
        "the sensors' noise; a channel that the model misses by more than noise counts by the "
        "logarithm of its misfit. Each run's start pose, the force of its knock and an unknown "
        "camera clock are estimated with them. The search begins in several valleys of a "
        "scan over pretension and friction, since single starts end in local minima.",
        *(_readable(paragraph) for paragraph in paragraphs),
    )


_READABLE = (
    (r"\$\$?", ""),
    (r"\\Big", ""),
    (r"\\sum_g", "Σ_g"),
    (r"\^\{-1\}", "⁻¹"),
    (r"\^T", "ᵀ"),
    (r"\s+", " "),
)


def _readable(paragraph: str) -> str:
    for pattern, replacement in _READABLE:
        paragraph = re.sub(pattern, replacement, paragraph)
    return paragraph.strip()


def _parameter_pictures(
    estimate: Estimate, truth: dict[str, float] | None, picture: Pictures
) -> Iterator[Picture]:
    free = estimated(estimate)
    if not free:
        return
    if estimate.fits:
        yield _intervals(free, truth, picture)
    if len(free) > 1:
        yield picture(
            correlation([shown_name(parameter) for parameter in free], estimate.correlation),
            "Correlation of the estimates. Near ±1 (bold, framed) the data tell only a "
            "combination of the two, such as the product of friction and pretension.",
            narrow=True,
        )


def _intervals(
    free: Sequence[ParameterEstimate], truth: dict[str, float] | None, picture: Pictures
) -> Picture:
    return picture(
        intervals(free, truth=truth),
        "How well each parameter is known: the shorter the bar, the better. A bar that "
        "reaches the dashed lines is weakly identified or not at all. What may be zero is "
        "held against a tenth of its usual size where that is more than its value."
        + (
            " A cross left of its bar's end: the truth is inside the interval." if truth else ""
        ),
        narrow=True,
    )


def _fit_pictures(estimate: Estimate, picture: Pictures) -> Iterator[Picture]:
    yield picture(
        fit_overview(estimate.comparisons),
        "Mean squared residual over the sensor's variance, for each run and channel. Near 1 "
        "(up to 3 for an encoder that stands still) nothing but noise is left; 100 means "
        "residuals of ten times the noise. Bold and framed: look at that run below.",
        narrow=True,
    )
    moved = [run for run in estimate.comparisons if run.path.size]
    if moved:
        chosen = max(moved, key=lambda run: (run.held_out, float(np.ptp(run.path[:, 0]))))
        yield picture(
            robot_view(
                estimate.robot,
                time=chosen.time,
                path=chosen.path,
                instants=shown_instants(chosen.time),
            ),
            f"The simulated robot in run {chosen.name}, to scale: the end-effector's path in "
            "red, cables on the paths alpha (blue), beta (green) and gamma (purple), driver "
            "pulleys in the lower corners. Watch how far the carriages part and the "
            "end-effector tilts. Its width and the deflection pulleys aren't in the model.",
        )


def _predictions(predictions: Sequence[Prediction]) -> Table:
    return table_of(
        "",
        (
            {
                "run": prediction.run,
                "error, rms [mm]": plain(1e3 * prediction.error),
                "largest [mm]": plain(1e3 * prediction.largest),
                "motion [mm]": plain(1e3 * prediction.motion, 4),
                "rms over motion": percent(prediction.share),
            }
            for prediction in predictions
        ),
    )


def _map_pictures(findings: Findings, picture: Pictures) -> Iterator[Picture]:
    frequencies, robot = findings.frequencies, findings.estimate.robot
    frame = tuple(float(value(robot, f"frame_{side}")) for side in ("width", "height"))
    yield picture(
        frequency_map(
            frequencies, size=frame, settings=sorted(set(frequencies.pretension.tolist()))
        ),
        "Natural frequency where the end-effector was knocked, with its standard error. A "
        "square: the carriages were still sliding, so that the frequency depends on the "
        "amplitude.",
    )
    yield picture(
        frequency_over_height(frequencies, findings.model_curves),
        "The same beside the fitted model with both carriages held by friction. Points on a "
        "curve: the pretension that the motion asks for also explains the vibration. Points "
        "off both curves: something else holds the carriages, or the model lacks a compliance.",
        narrow=True,
    )
    for decay in findings.decays:
        yield picture(
            ring_down_figure(decay),
            f"Run {decay.run}: the free vibration after the knock, and its spectrum with the "
            "fitted frequency (solid) and the highest peak (dotted). The red line should go "
            "through the dots.",
        )


def _run(campaign: Campaign, comparison: Comparison, picture: Pictures) -> dict[str, Any]:
    run = campaign.run(comparison.name)
    return {
        "name": comparison.name,
        "kind": comparison.kind.replace("_", " "),
        "setting": run.pretension_label,
        "notes": run.notes,
        "held_out": comparison.held_out,
        "pictures": [
            picture(
                run_comparison(comparison),
                "Blue dots: camera. Thick blue line: encoder. Red: simulated, it should go "
                "through the dots and lie inside the thick line.",
            ),
            picture(
                residuals(comparison),
                "What is left, in standard deviations of the sensor. A cloud inside the grey "
                "band is noise; a wave or a step is something that the model doesn't have.",
            ),
        ],
    }


def _minima(valleys: Sequence[Valley]) -> list[tuple[str, str]]:
    """Every minimum that the search came by, so that one sees how clear the choice was."""
    return [
        (
            f"minimum {number} at {valley.setting}",
            f"T {plain(valley.pretension, 4)} N, μ {plain(valley.friction_coefficient, 3)}: "
            f"misfit {plain(valley.misfit, 3)} per measurement of the runs that it was "
            "sought with",
        )
        for number, valley in enumerate(valleys, start=1)
    ]


def _provenance(campaign: Campaign, estimate: Estimate) -> list[tuple[str, str]]:
    fit = estimate.fit
    fitted = ", ".join(run.name for run in estimate.comparisons if not run.held_out)
    held_out = ", ".join(run.name for run in estimate.comparisons if run.held_out)
    sensors = dataclasses.asdict(campaign.sensors)
    return [
        ("fitted runs", fitted),
        ("held-out runs", held_out or "none"),
        ("skipped runs", ", ".join(name for name, _ in campaign.skipped) or "none"),
        ("independent measurements", f"{fit.measurements:.0f}"),
        ("fit", f"{fit.ended} after {fit.iterations} evaluations; {len(fit.starts)} starts"),
        *_minima(fit.valleys),
        ("encoder noise, σ", f"{1e3 * sensors['encoder_sigma']:.4g} mrad"),
        (
            "camera noise, σ",
            f"{1e3 * sensors['camera_position_sigma']:.4g} mm, "
            f"{1e3 * sensors['camera_angle_sigma']:.4g} mrad",
        ),
        *versions(),
    ]
