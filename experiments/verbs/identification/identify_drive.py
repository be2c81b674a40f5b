"""`scdpr identify-drive`: one motor-driven axis."""

import pathlib

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, open_call, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out


def identify_drive(log: Folder, /, gain: str, out: pathlib.Path, delay_samples: int = 0) -> int:
    """Estimate one motor-driven axis from a log of voltage and position.

    Args:
        log: CSV file with the columns t, voltage and position, units in the header.
        gain: Force of the drive per volt, with its unit: "35.1507 N/V"; of a rotary axis,
            whose positions are angles, its torque: "0.05 N m/V".
        out: Folder for parameters.json and report.html.
        delay_samples: Samples by which the logged voltage acts late.
    """
    try_out(out / "parameters.json")
    set_up()
    from experiments.reports import summary
    from experiments.reports.drive.report import write_drive_report
    from identification.axis.law import axis_laws
    from identification.axis.log import read_axis_log
    from identification.campaign.quantities import QuantityError, parse_quantity
    from identification.result.axis_file import write_axis_parameters
    from scdpr_jax.provenance import hash_of, made_today

    read = read_axis_log(log)
    unit = "N m/V" if read.is_rotary else "N/V"
    try:
        force = parse_quantity(gain, unit=unit, name="--gain")
    except QuantityError as error:
        kind = (
            "an angle: the gain is a torque per volt"
            if read.is_rotary
            else "a length: the gain is a force per volt"
        )
        raise ValueError(f"{error} The position of {log} is {kind} [{unit}].") from None
    with shown_progress(ERRORS, "identify-drive") as progress:
        progress("fits from several starts, half a minute for a long log", 0.0)
        laws = axis_laws(read, gain=force, delay_samples=delay_samples)
    made = made_today(log.name, hash_of([log], log.parent))
    write_axis_parameters(out / "parameters.json", laws, provenance=made)
    write_drive_report(out / "report.html", log=read, laws=laws)
    summary.show_axis(OUT, laws)
    wrote(out / "parameters.json", out / "report.html")
    suggest(open_call(out / "report.html"))
    return DONE if laws.usual.converged and laws.preferred.fits else FELL_SHORT
