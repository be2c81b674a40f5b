"""`scdpr sweep`: a grid of poses and parameters, computed."""

import pathlib
from typing import Annotated, Literal

import tyro

from experiments.cli import DONE
from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, suggest, wrote


def sweep(
    measure: Annotated[Literal["frequency", "workspace", "closed-loop"], tyro.conf.Positional],
    /,
    over: tuple[str, ...],
    out: pathlib.Path,
    parameters: pathlib.Path | None = None,
    setting: str | None = None,
    precision: Literal["single", "double"] = "double",
) -> int:
    """Compute natural frequencies, static workspaces or a closed-loop move over a grid.

    The same call goes on where a stopped one was.

    Args:
        measure: What to compute of every point. frequency: of an aligned pose, under every
            condition of the carriages. workspace: the single loop's and the conventional
            four-cable robot's. closed-loop: errors and vibration of a move under the PD.
        over: Axes, each `NAME=LOW..HIGH:COUNT UNIT` or `NAME=VALUE, VALUE UNIT`, like
            "y=0.2..0.9:50 m" "effective_pretension=70, 85, 100 N". NAME is x, y, a
            quantity of the robot, or one of the measure's own; a wrong one lists them all.
        out: netCDF file.
        parameters: parameters.json of `scdpr identify`; default: the paper's prototype.
        setting: Nominal pretension, "350 N"; default: the first of the parameters.
        precision: Of the numbers; single is enough for maps, and takes half the memory.
    """
    set_up(double=precision == "double", all_cores=True)
    from experiments import summary
    from experiments.parameters_file import read_parameters
    from experiments.sweep.axes import parse_axis
    from experiments.sweep.measures import MEASURES
    from experiments.sweep.run import sweep as run_sweep
    from scdpr_jax.prototype import consistent

    robot = consistent()
    if parameters is not None:
        fitted = read_parameters(parameters)
        robot = fitted.of_setting(setting) if setting else fitted.robot
    elif setting is not None:
        raise ValueError(
            f"`--setting` belongs to `--parameters`, got {setting!r} alone. The prototype's "
            'pretension is an axis: --over "effective_pretension=85 N".'
        )
    variables = MEASURES[measure].variables_of(robot)
    axes = tuple(parse_axis(text, variables) for text in over)
    names = [axis.variable.name for axis in axes]
    if not axes or len(set(names)) != len(names):
        raise ValueError(
            f"`--over` must name one axis or more, each once, got {', '.join(names) or 'none'}"
            f". Choose from: {', '.join(variables)}."
        )
    with shown_progress(ERRORS) as progress:
        found = run_sweep(measure, axes, robot, out, progress=progress)
    summary.show_sweep(OUT, found)
    wrote(out)
    suggest(f'python -c "import xarray; print(xarray.open_dataset({str(out)!r}))"')
    return DONE
