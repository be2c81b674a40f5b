"""`scdpr design`: which experiment next."""

import pathlib
from typing import Annotated

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, pasted, suggest, wrote
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out


def design(
    parameters: Folder,
    /,
    wanted: Annotated[str, tyro.conf.arg(name="for")],
    out: pathlib.Path,
    seconds: float = 2.0,
    setting: str | None = None,
    log_rate: str = "1 kHz",
    top_speed: str = "1.5 m/s",
    seed: int = 0,
) -> int:
    """Design the run that narrows a parameter's interval the most per second of rig time.

    Torque steps, staircases, chirps, multisines and knocks from several poses are compared by
    the interval that a fit with them is expected to end at, over robots that what is known
    allows for; the best are improved by gradient, within voltage, frame and speed.

    Args:
        parameters: parameters.json of `scdpr identify` or `scdpr calibrate`.
        wanted: The parameter, by name or as mu, J, b, T_eff or tau_f; or d-optimal or
            a-optimal for all of them.
        out: The table of voltages to write, next_run.csv; a figure is written beside it.
        seconds: Longest run [s]; runs of half of it are looked at, too.
        setting: Nominal pretension of the run, "350 N"; default: the first one known.
        log_rate: Rate of the drives' log.
        top_speed: Largest speed of the end-effector in either direction.
        seed: Of the robots that are drawn.
    """
    try_out(out, out.with_suffix(".png"))
    set_up()
    import jax

    from experiments.figures.identification.next_run import next_run_figure
    from experiments.page.console_text import print_lines, print_table
    from experiments.studies import next_run
    from experiments.studies.known_rig import caution, known_rig, poses
    from identification.campaign.quantities import parse_quantity
    from identification.next_run.excitation import catalogue
    from identification.next_run.next_experiment import propose
    from identification.result.parameters_file import read_parameters
    from scdpr_jax.numerics.files import whole_file, write_whole
    from scdpr_jax.robot.quantities import value

    fitted = read_parameters(parameters)
    rig = known_rig(
        fitted,
        setting=setting,
        log_rate=parse_quantity(log_rate, unit="Hz", name="--log-rate"),
        top_speed=parse_quantity(top_speed, unit="m/s", name="--top-speed"),
    )
    aim = next_run.aim_for(wanted, rig)
    excitations = catalogue(
        limit=float(value(rig.robot, "voltage_limit")),
        duration=seconds,
        poses=poses(rig.robot),
    )
    with shown_progress(ERRORS, "design") as progress:
        candidates = propose(
            rig, excitations, aim.criterion, key=jax.random.key(seed), progress=progress
        )
    best, status = candidates[0], ending(parameters, fits=fitted.fits)
    print_table(OUT, next_run.candidate_table(rig, aim, candidates))
    print_lines(
        OUT,
        (
            next_run.chosen_sentence(candidates),
            caution(fitted.residuals),
            *next_run.instructions(best),
        ),
    )
    drawn = out.with_suffix(".png")
    write_whole(out, next_run.voltage_table(best))
    with whole_file(drawn) as scratch:
        next_run_figure(rig, aim, candidates).savefig(scratch, format="png", dpi=150)
    wrote(out, drawn)
    suggest(
        "make the run, log it into a new folder of the campaign",
        f"scdpr identify CAMPAIGN --out {pasted(parameters.resolve().parent)}",
    )
    return status
