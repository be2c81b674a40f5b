"""A small folder of results, as `scdpr calibrate` leaves one."""

import report_samples
import tunings

from experiments.studies.runs_file import runs_table
from identification.result.parameters_file import write_parameters
from tuning.result.document import write_tuning


def write_results(folder):
    """Parameters, a tuning with its robot, runs, a report and an export."""
    found = report_samples.estimate()
    write_parameters(folder / "parameters.json", report_samples.complete(found))
    write_tuning(folder / "tuning.json", tunings.plain())
    (folder / "runs.csv").write_text(runs_table(found.comparisons), encoding="utf-8")
    (folder / "report.html").write_text("<p>the report</p>", encoding="utf-8")
    (folder / "export").mkdir()
    (folder / "export" / "controller.csv").write_text("a,b\n1,2\n")
    return folder
