"""The files of a calibration, each by its name."""

import concurrent.futures
import dataclasses
import pathlib

from experiments.reports.report import FitPictures, write_report
from experiments.reports.tuning.files import TuningFiles, write_tuned
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.tuning import TuningFindings
from experiments.studies.runs_file import runs_table
from identification.knocks.frequency_map import write_frequencies
from identification.result.parameters_file import write_parameters
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.provenance import Provenance, made_today


@dataclasses.dataclass(frozen=True)
class CalibrationFiles:
    """Where a calibration was written."""

    report: pathlib.Path
    """The report, `report.html`."""
    parameters: pathlib.Path
    """The estimate, `parameters.json`."""
    runs: pathlib.Path
    """Where the fitted robot goes in each run, `runs.csv`."""
    frequencies: pathlib.Path | None
    """Natural frequencies, `frequencies.csv`; None if no knock gives one."""
    tuning: TuningFiles | None
    """Gains and shapers; None if none are made from a fit that has failed."""

    @property
    def paths(self) -> tuple[pathlib.Path, ...]:
        """All of them, the report first."""
        frequencies = () if self.frequencies is None else (self.frequencies,)
        tuning = () if self.tuning is None else self.tuning.paths
        return (self.report, self.parameters, self.runs, *frequencies, *tuning)


def write_calibration(
    findings: Findings,
    out: pathlib.Path,
    *,
    truth: dict[str, float] | None = None,
    pictures: FitPictures | None = None,
    progress: Progress = SILENT,
) -> CalibrationFiles:
    """Write everything that a calibration gives, each file whole or not at all.

    Args:
        findings: What it comes to.
        out: The folder.
        truth: True values by name, where they are known.
        pictures: The report's pictures of the fit, if they have been begun.
        progress: Told which share of it is done.

    Returns:
        The files.
    """
    progress("report", 0.0)
    mapped = findings.frequencies is not None
    parameters = out / "parameters.json"
    made = made_today(findings.campaign.name, findings.campaign.source)
    write_parameters(
        parameters,
        findings.estimate,
        accepted=findings.campaign.accepted,
        provenance=made,
    )
    if mapped:
        write_frequencies(findings.frequencies, out / "frequencies.csv", provenance=made)
    runs = out / "runs.csv"
    write_whole(runs, runs_table(findings.estimate.comparisons))
    report = out / "report.html"
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # The planner's self-test is planned by machine code while figures are made.
        tuning = aside.submit(_write_tuned, out, findings.tuning, made)
        write_report(
            report,
            findings,
            title=f"Calibration of {findings.campaign.name}",
            truth=truth,
            pictures=pictures,
            progress=progress,
        )
    mapping = out / "frequencies.csv" if mapped else None
    return CalibrationFiles(report, parameters, runs, mapping, tuning.result())


def _write_tuned(
    out: pathlib.Path, findings: TuningFindings | None, made: Provenance
) -> TuningFiles | None:
    if findings is None:
        return None
    return write_tuned(out, dataclasses.replace(findings.tuning, provenance=made))
