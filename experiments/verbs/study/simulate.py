"""`scdpr simulate`: one manoeuvre of a fitted robot."""

import pathlib

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, pasted, plan_call, say, suggest, wrote
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import try_out


def simulate(
    parameters: pathlib.Path,
    out: pathlib.Path,
    manoeuvre: str = "horizontal",
    leg_time: str = "2 s",
    setting: str | None = None,
    tuning: pathlib.Path | None = None,
) -> int:
    """Simulate a manoeuvre of Table 3 with a fitted robot.

    Args:
        parameters: parameters.json of `scdpr identify` or `scdpr calibrate`.
        out: Folder for simulation.csv.
        manoeuvre: horizontal, vertical or diagonal.
        leg_time: Time of one leg, with its unit.
        setting: Nominal pretension, "350 N"; default: the first of the parameters.
        tuning: tuning.json for its gains and shaper; default: the PD of Eq. (25) alone.
    """
    try_out(out / "simulation.csv")
    set_up()
    from experiments.studies import simulated_run
    from identification.campaign.quantities import parse_quantity
    from identification.result.parameters_file import read_parameters
    from scdpr_jax.numerics.files import write_whole
    from tuning.result.document import read_tuning

    fitted = read_parameters(parameters)
    label = setting or (fitted.settings[0] if fitted.settings else "0 N")
    pretension = parse_quantity(label, unit="N", name="--setting")
    leg = parse_quantity(leg_time, unit="s", name="--leg-time")
    reference = simulated_run.manoeuvre(manoeuvre, leg)
    tuned = None if tuning is None else read_tuning(tuning)
    with shown_progress(ERRORS, "simulate") as progress:
        progress("simulating", 0.0)
        run = simulated_run.simulate(fitted.of_setting(label), reference, tuned, pretension)
    write_whole(out / "simulation.csv", simulated_run.table(run))
    sound = fitted.fits and (tuned is None or not tuned.caution)
    status = ending(parameters if tuning is None or not fitted.fits else tuning, fits=sound)
    say(simulated_run.sentence(run))
    wrote(out / "simulation.csv")
    suggest(
        f"scdpr tune --parameters {pasted(parameters)} --frequencies "
        f"{pasted(parameters.with_name('frequencies.csv'))} --out {pasted(out)}"
        if tuning is None
        else plan_call(tuning)
    )
    return status
