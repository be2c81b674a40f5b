"""`scdpr codesign`: gains, shaper and leg together."""

import dataclasses
import pathlib
from typing import TYPE_CHECKING

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import (
    ERRORS,
    OUT,
    Folder,
    open_call,
    plan_call,
    suggest,
    tell_distrusted,
    wrote,
)
from experiments.verbs.exit_status import FELL_SHORT
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out

if TYPE_CHECKING:
    from identification.result.fitted_robot import FittedRobot
    from tuning.codesign import CoDesign


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
    cores: int | None = None,
    cluster: str | None = None,
    certificates: pathlib.Path | None = None,
) -> int:
    """Design gains, shaper and the shape of a leg for the worst over the whole workspace.

    Every design is run through the nonlinear robot with exact friction, saturated drives and
    encoders, on legs to every pose of a grid, at every pretension, with every sample of what
    the fit leaves open; the worst tenth of these decide. Beside it stand the PD of Eq. (25)
    alone and with a ZV shaper, also on robots and poses that the design hasn't seen.

    A co-design that was stopped goes on where it was: give the same call again.

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
        cores: Processes of this machine to share the searches among; default: this one, on all
            its cores. The result is the same.
        cluster: A dask cluster to share them among, tcp://HOST:PORT or tls://HOST:PORT, or
            local:N for one of N workers on this machine. Needs the extra `cluster`.
        certificates: Folder with ca.pem, cert.pem and key.pem, for tls://.
    """
    from experiments.runtime.executors.chosen import chosen, require_cluster

    require_cluster(cluster, certificates, cores)
    try_out(out / "codesign.json")
    set_up()
    from experiments.reports import codesign_report
    from experiments.studies.codesign.kept import kept_designs
    from experiments.studies.codesign.run import design, parse_grid
    from experiments.studies.posterior import nominal_settings
    from identification.campaign.quantities import parse_quantity
    from identification.result.parameters_file import read_parameters
    from tuning.codesign import Scope
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
    with (
        shown_progress(ERRORS, "codesign") as progress,
        chosen(cluster, certificates, cores or 1) as executor,
        kept_designs(out, executor, distrusted=tell_distrusted) as designer,
    ):
        co_design = design(fitted, scope, designer=designer, progress=progress)
        files = _written(out, co_design, fitted, name=str(parameters), caution=caution)
    status = ending(parameters, fits=fitted.fits)
    codesign_report.show(OUT, co_design, caution=caution)
    wrote(*files)
    suggest(open_call(out / "codesign.html"), plan_call(out / "codesign.json"))
    return status if co_design.holds else FELL_SHORT


def _written(
    out: pathlib.Path, co_design: "CoDesign", fitted: "FittedRobot", *, name: str, caution: str
) -> list[pathlib.Path]:
    """Everything that is written of a co-design."""
    from experiments.reports import codesign_report
    from scdpr_jax.numerics.files import settle, write_whole
    from scdpr_jax.provenance import of_no_day
    from tuning.codesign import write_codesign
    from tuning.codesign.as_tuning import tuning_of
    from tuning.export import write_exports
    from tuning.loop.worst_margins import margin_map

    result, report = out / "codesign.json", out / "codesign.html"
    # It may be gone on with tomorrow, to the same bytes.
    made = of_no_day(fitted.provenance.campaign, fitted.provenance.source)
    write_codesign(result, co_design, caution=caution, provenance=made)
    tuned = dataclasses.replace(tuning_of(co_design, caution=caution), provenance=made)
    exports = write_exports(out / "export", tuned)
    margins = margin_map(co_design.robots, co_design.chosen.law.controller)
    page = codesign_report.codesign_page(co_design, margins, name=name, caution=caution)
    write_whole(report, page)
    settle(out)
    return [result, report, *exports]
