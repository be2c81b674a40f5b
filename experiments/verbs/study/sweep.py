"""`scdpr sweep`: a grid of poses and parameters, computed."""

import pathlib
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import (
    ERRORS,
    OUT,
    complain,
    open_call,
    suggest,
    tell_distrusted,
    wrote,
)
from experiments.verbs.exit_status import DONE
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out

if TYPE_CHECKING:
    from scdpr_jax.provenance import Provenance
    from scdpr_jax.robot.parameters import Robot


def sweep(
    measure: Annotated[Literal["frequency", "workspace", "closed-loop"], tyro.conf.Positional],
    /,
    over: tuple[str, ...],
    out: pathlib.Path,
    parameters: pathlib.Path | None = None,
    setting: str | None = None,
    precision: Literal["single", "double"] = "double",
    cores: int | None = None,
    cluster: str | None = None,
    certificates: pathlib.Path | None = None,
) -> int:
    """Compute natural frequencies, static workspaces or a closed-loop move over a grid.

    A sweep that was stopped goes on where it was: give the same call again.

    Args:
        measure: What to compute of every point. frequency: of an aligned pose, under every
            condition of the carriages. workspace: the single loop's and the conventional
            four-cable robot's. closed-loop: errors and vibration of a move under the PD.
        over: Axes, each "NAME=LOW..HIGH:COUNT UNIT" or "NAME=VALUE, VALUE UNIT", like
            "y=0.2..0.9:50 m" "effective_pretension=70, 85, 100 N". NAME is x, y, a
            quantity of the robot, or one of the measure's own; a wrong one lists them all.
        out: netCDF file, .nc; a picture with the same name, .png, shows it.
        parameters: parameters.json of `scdpr identify`; default: the paper's prototype.
        setting: Nominal pretension, "350 N"; default: the first of the parameters.
        precision: Of the numbers; single is enough for maps and takes half the memory.
        cores: Processes of this machine to share the points among; default: this one, on all
            its cores. The bits are the same.
        cluster: A dask cluster to share them among, tcp://HOST:PORT or tls://HOST:PORT, or
            local:N for one of N workers on this machine. Needs the extra `cluster`.
        certificates: Folder with ca.pem, cert.pem and key.pem, for tls://.
    """
    from experiments.runtime.executors.chosen import chosen, require_cluster

    require_cluster(cluster, certificates, cores)
    try_out(out)
    set_up(double=precision == "double", all_cores=True)
    from experiments.figures.sweep_map import sweep_map
    from experiments.sweep.axes import parse_axes
    from experiments.sweep.extent import check_name, check_places, check_room
    from experiments.sweep.measures import MEASURES
    from experiments.sweep.run import sweep as run_sweep
    from experiments.sweep.show import show
    from scdpr_jax.numerics.files import whole_file

    check_name(out)
    wanted = next(m for m in MEASURES if m.name == measure)
    axes = parse_axes(over, wanted.known)
    robot, fits, provenance = _robot(parameters, setting)
    check_places(axes, robot)
    if warning := check_room(wanted, axes, out):
        complain(f"warning: {warning}")
    with (
        shown_progress(ERRORS, f"sweep {measure}") as progress,
        chosen(cluster, certificates, cores or 1) as executor,
    ):
        dataset = run_sweep(
            wanted,
            axes,
            robot,
            out,
            provenance=provenance,
            executor=executor,
            distrusted=tell_distrusted,
            progress=progress,
        )
    status = DONE if parameters is None else ending(parameters, fits=fits)
    with dataset:
        show(OUT, dataset, axes=len(axes))
        drawn = out.with_suffix(".png")
        with whole_file(drawn) as scratch:
            sweep_map(dataset, axes=len(axes)).savefig(scratch, format="png", dpi=150)
    wrote(out, drawn)
    suggest(
        open_call(drawn),
        f'python -c "import xarray; print(xarray.open_dataset({str(out)!r}))"',
    )
    return status


def _robot(
    parameters: pathlib.Path | None, setting: str | None
) -> "tuple[Robot, bool, Provenance]":
    """The robot of the sweep, whether its fit hasn't failed, and where it comes from."""
    from identification.result.parameters_file import read_parameters
    from scdpr_jax.provenance import UNKNOWN
    from scdpr_jax.robot.prototype import consistent

    if parameters is not None:
        fitted = read_parameters(parameters)
        robot = fitted.of_setting(setting) if setting else fitted.robot
        return robot, fitted.fits, fitted.provenance
    if setting is not None:
        raise ValueError(
            f"`--setting` belongs to `--parameters`, got {setting!r} alone. The prototype's "
            'pretension is an axis: --over "effective_pretension=85 N".'
        )
    return consistent(), True, UNKNOWN
