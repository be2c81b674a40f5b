"""`scdpr identify-drive`: one motor-driven axis."""

import pathlib

from experiments.runtime import set_up
from experiments.verbs.console import ERRORS, OUT, Folder, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT


def identify_drive(log: Folder, /, gain: str, out: pathlib.Path, delay_samples: int = 0) -> int:
    """Estimate one motor-driven axis from a log of voltage and position.

    Args:
        log: CSV file with the columns t, voltage and position, units in the header.
        gain: Force of the drive per volt, with its unit: "35.1507 N/V".
        out: Folder for parameters.json and report.html.
        delay_samples: Samples by which the logged voltage acts late.
    """
    set_up()
    from experiments.reports import report, summary
    from identification.axis.drive_axis import estimate_drive_axis
    from identification.axis.law import compare_axis_laws
    from identification.axis.log import read_axis_log
    from identification.campaign.quantities import parse_quantity
    from identification.result.axis_file import write_axis_parameters

    force = parse_quantity(gain, unit="N/V", name="--gain")
    read = read_axis_log(log)
    with ERRORS.status("open-loop fits from several starts, some ten seconds"):
        axis = estimate_drive_axis(read, gain=force, delay_samples=delay_samples)
        laws = compare_axis_laws(read, axis, gain=force, delay_samples=delay_samples)
    write_axis_parameters(out / "parameters.json", axis, laws)
    report.write_drive_report(out / "report.html", log=read, estimate=axis, laws=laws)
    summary.show_axis(OUT, axis, laws, position_unit=read.position_unit)
    wrote(out / "parameters.json", out / "report.html")
    return DONE if axis.converged else FELL_SHORT
