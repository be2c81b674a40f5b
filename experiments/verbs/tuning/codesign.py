"""`scdpr codesign`: gains, shaper and leg together."""

import dataclasses
import pathlib

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, open_call, plan_call, suggest, wrote
from experiments.verbs.exit_status import FELL_SHORT
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out


def codesign(
    parameters: Folder,
    /,
    out: pathlib.Path,
    grid: str = "4x5",
    samples: int = 16,
    settings: tuple[str, ...] = (),
    move_times: tuple[str, ...] = (),
    seed: int = 1,
    force: bool = False,
) -> int:
    """Design gains, shaper and the shape of a leg for the worst over the whole workspace.

    Every design is run through the nonlinear robot with exact friction, saturated drives and
    encoders, on legs to every pose of a grid, at every pretension, with every sample of what
    the fit leaves open; the worst tenth of these decide. Beside it stand the PD of Eq. (25)
    alone and with a ZV shaper, also on robots and poses that the design hasn't seen.

    Args:
        parameters: parameters.json of `scdpr identify` or `scdpr calibrate`.
        out: Folder for codesign.json, codesign.html and, in its folder export, the gains and
            the shaper in C, for LabVIEW and for MATLAB. `scdpr plan` takes codesign.json.
        grid: Poses that legs end at, "columns x rows".
        samples: Robots that are drawn from the fit's covariance.
        settings: Nominal pretensions to design for, "200 N" "350 N" "500 N"; default:
            those that were fitted.
        move_times: Times that a move may take with its shaper, "2.4 s" or several; default:
            four, from what the drives just can.
        seed: Of the samples.
        force: Design for parameters whose fit has failed, too; every file is marked.
    """
    try_out(out / "codesign.json")
    set_up()
    from experiments.reports import codesign_report
    from experiments.studies.codesign_run import design, parse_grid
    from experiments.studies.posterior import nominal_settings
    from identification.campaign.quantities import parse_quantity
    from identification.result.parameters_file import read_parameters
    from scdpr_jax.numerics.files import write_whole
    from scdpr_jax.provenance import made_today
    from tuning.codesign import Scope, write_codesign
    from tuning.codesign.as_tuning import tuning_of
    from tuning.export import write_exports
    from tuning.loop.worst_margins import margin_map
    from tuning.result.tuning import CAUTION

    fitted = read_parameters(parameters)
    caution = "" if fitted.fits else CAUTION
    if caution and not force:
        raise ValueError(f"{parameters}: {caution} `--force` designs all the same.")
    nominal = tuple(parse_quantity(text, unit="N", name="--settings") for text in settings)
    scope = Scope(
        grid=parse_grid(grid),
        samples=samples,
        settings=tuple(sorted(nominal)) or nominal_settings(fitted),
        move_times=tuple(
            parse_quantity(text, unit="s", name="--move-times") for text in move_times
        ),
        seed=seed,
    )
    with shown_progress(ERRORS, "codesign") as progress:
        co_design = design(fitted, scope, progress=progress)
    result, report = out / "codesign.json", out / "codesign.html"
    made = made_today(fitted.provenance.campaign, fitted.provenance.source)
    write_codesign(result, co_design, caution=caution, provenance=made)
    tuned = dataclasses.replace(tuning_of(co_design, caution=caution), provenance=made)
    exports = write_exports(out / "export", tuned)
    margins = margin_map(co_design.robots, co_design.chosen.law.controller)
    page = codesign_report.codesign_page(
        co_design, margins, name=str(parameters), caution=caution
    )
    write_whole(report, page)
    status = ending(parameters, fits=fitted.fits)
    codesign_report.show(OUT, co_design, caution=caution)
    wrote(result, report, *exports)
    suggest(open_call(report), plan_call(result))
    return status if co_design.holds else FELL_SHORT
