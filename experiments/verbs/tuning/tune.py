"""`scdpr tune`: gains and shapers."""

import dataclasses
import pathlib

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, pasted, plan_call, suggest, wrote
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out


def tune(
    parameters: pathlib.Path,
    frequencies: pathlib.Path,
    out: pathlib.Path,
    force: bool = False,
) -> int:
    """Design gains and a shaper for each region of the workspace.

    Args:
        parameters: parameters.json of `scdpr identify`.
        frequencies: frequencies.csv of `scdpr frequencies`.
        out: Folder for tuning.json and, in its folder export, the tuning in C, for LabVIEW
            and for MATLAB.
        force: Tune for parameters whose fit has failed, too; every file is marked.
    """
    try_out(out / "tuning.json")
    set_up()
    from experiments.reports import summary
    from experiments.reports.tuning.files import write_tuned
    from experiments.studies.posterior import draws_of
    from identification.knocks.frequency_map import read_frequencies
    from identification.result.parameters_file import read_parameters
    from scdpr_jax.provenance import made_today
    from tuning.gains.tune import tune as design

    fitted = read_parameters(parameters)
    measured = read_frequencies(frequencies)
    with shown_progress(ERRORS, "tune") as progress:
        tuned = design(fitted, measured, draws=draws_of(fitted), force=force, progress=progress)
    made = made_today(fitted.provenance.campaign, fitted.provenance.source)
    written = write_tuned(out, dataclasses.replace(tuned, provenance=made))
    status = ending(parameters, fits=fitted.fits)
    summary.show_tuning(OUT, tuned)
    wrote(*written.paths)
    suggest(
        f"scdpr simulate --parameters {pasted(parameters)} --tuning {pasted(written.tuning)} "
        f"--out {pasted(out)}",
        plan_call(written.tuning),
    )
    return status
