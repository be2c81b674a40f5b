"""The calibration's report: one HTML file that needs nothing else."""

import dataclasses
import inspect
import math
import pathlib
import re
from collections.abc import Sequence
from typing import Any

from experiments.page.number_text import percent, plain, short
from experiments.page.page import page, versions
from experiments.page.table import Table, table_of
from experiments.reports.calibration.first_screen import first_screen
from experiments.reports.calibration.fit_pictures import FitPictures as FitPictures
from experiments.reports.calibration.fit_pictures import run_film, runs_to_draw
from experiments.reports.calibration.frequency_pictures import frequency_pictures
from experiments.reports.calibration.heat_tables import (
    correlation_heat,
    misfit_heat,
    quantity_symbols,
)
from experiments.reports.calibration.influence_tables import influence_tables
from experiments.reports.calibration.knock_table import knock_table_with_fft
from experiments.reports.model_tables import measured_tables, model_tables, moved_table
from experiments.reports.parameter_table import parameter_row
from experiments.reports.tuning.pictures import tuning_film, tuning_pictures
from experiments.reports.tuning.tables import tuning_tables
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.influence import influence_sentences
from experiments.studies.findings.models import combination_sentences
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.predictions import Prediction
from experiments.studies.findings.tuning import TuningFindings
from identification.campaign.types import Campaign
from identification.fit.starts import Valley
from identification.judge.uncertainty import covariance
from identification.result.estimate import Estimate
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.progress import SILENT, Progress


def write_report(
    path: pathlib.Path,
    findings: Findings,
    *,
    title: str,
    truth: dict[str, float] | None,
    pictures: FitPictures | None = None,
    progress: Progress = SILENT,
) -> None:
    """Write the report of a calibration, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        findings: What the calibration comes to; it has its campaign.
        title: Its title.
        truth: True values by name [SI], where they are known.
        pictures: The pictures of the fit, if they have been begun.
        progress: Told which share of it is done.

    Raises:
        OSError: If the place can't be written to.
    """
    if pictures is None:
        pictures = FitPictures(findings.campaign, truth=truth)
        pictures.begin(findings.estimate)
    progress("report: figures of the fit", 0.1)
    of_fit = _of_fit(findings, truth, pictures)
    progress("report: figures of the tuning", 0.4)
    of_tuning = _of_tuning(findings, pictures)
    progress("report: page", 0.6)  # which waits for figures that other processes draw
    text = page(
        "report.html.j2",
        title=title,
        campaign=findings.campaign,
        first=first_screen(findings),
        words=findings.words,
        verdict=findings.verdict,
        found=findings.words.found + _tuning_sentences(findings.tuning),
        notes=findings.notes,
        with_truth=bool(truth),
        method=method_notes(),
        provenance=_provenance(findings.campaign, findings.estimate),
        **of_fit,
        **of_tuning,
    )
    write_whole(pathlib.Path(path), text)


def _of_fit(
    findings: Findings, truth: dict[str, float] | None, pictures: FitPictures
) -> dict[str, Any]:
    """What the page has of parameters, residuals and frequencies."""
    estimate, frequencies = findings.estimate, findings.frequencies
    free = estimated(estimate)
    symbols = quantity_symbols(tuple((p.name, p.setting) for p in free))
    _, left_out = runs_to_draw(estimate.comparisons)
    return {
        "rows": [parameter_row(parameter, truth=truth) for parameter in free],
        "fixed": [parameter_row(p) for p in estimate.parameters if p.status == "fixed"],
        "parameter_pictures": pictures.of_parameters,
        "correlation": (
            correlation_heat(symbols, estimate.correlation) if len(free) > 1 else None
        ),
        "misfits": misfit_heat(estimate.comparisons),
        "predictions": _predictions(findings.predictions),
        "model_tables": (*measured_tables(findings.measured), *model_tables(estimate)),
        "moved": moved_table(estimate.identifiability),
        "combinations": combination_sentences(estimate.identifiability),
        "influence_words": influence_sentences(findings.influence),
        "influence_tables": influence_tables(estimate),
        "knocks": None if frequencies is None else knock_table_with_fft(frequencies),
        "map_pictures": (
            [] if frequencies is None else list(frequency_pictures(findings, pictures.picture))
        ),
        "film": run_film(estimate, name="film-run"),
        "runs": pictures.of_runs,
        "not_drawn": [comparison.name for comparison in left_out],
    }


def _of_tuning(findings: Findings, pictures: FitPictures) -> dict[str, Any]:
    """What the page has of gains and shapers."""
    tuning, robot = findings.tuning, findings.estimate.robot
    if tuning is None:
        return {"tuning_tables": (), "tuning_pictures": (), "tuning_film": None}
    return {
        "tuning_tables": tuning_tables(tuning.tuning),
        "tuning_pictures": tuning_pictures(tuning, robot=robot, picture=pictures.picture),
        "tuning_film": tuning_film(tuning.tuning, robot, name="film-tuned"),
    }


def _tuning_sentences(tuning: TuningFindings | None) -> tuple[str, ...]:
    return () if tuning is None else (*tuning.sentences, *tuning.between_the_cells)


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
        "Misfit has one measure everywhere: the root mean square of the residuals over the "
        "noise of the sensor. For a whole model or minimum it is the root of the mean over all "
        "measurements, with the logarithm of large misfits as in the fit.",
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


def _minima(valleys: Sequence[Valley]) -> list[tuple[str, str]]:
    """Every minimum that the search came by, so that one sees how clear the choice was."""
    return [
        (
            f"minimum {number} at {valley.setting}",
            f"T {plain(valley.pretension, 4)} N, μ {plain(valley.friction_coefficient, 3)}: "
            f"{plain(math.sqrt(valley.misfit), 3)} times the noise in the runs that it was "
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
        (
            "fit",
            f"{fit.ended} after {fit.iterations} evaluations; "
            f"{len(fit.starts)} start{'s' * (len(fit.starts) != 1)}",
        ),
        *_minima(fit.valleys),
        ("encoder noise, σ", f"{short(1e3 * sensors['encoder_sigma'], 4)} mrad"),
        (
            "camera noise, σ",
            f"{short(1e3 * sensors['camera_position_sigma'], 4)} mm, "
            f"{short(1e3 * sensors['camera_angle_sigma'], 4)} mrad",
        ),
        *versions(),
    ]
