"""`scdpr plan`: the references and the feed-forward of one leg."""

import pathlib
from typing import Annotated

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, suggest, wrote
from experiments.verbs.failed_fit import ending


def plan(
    tuning: Folder,
    /,
    begin: Annotated[str, tyro.conf.arg(name="from")],
    to: str,
    out: pathlib.Path,
    leg_time: str | None = None,
    setting: str | None = None,
    force: bool = False,
) -> int:
    """Plan a leg that arrives without vibration: what the controller is to follow.

    The controller adds its PD on the pulleys' angles: V = Kp e + Kd de/dt + feedforward,
    within the drives' limit. Angles count from those at the leg's begin; the last row is
    held. A manoeuvre of several legs is one plan after the other.

    Args:
        tuning: tuning.json of `scdpr tune` or `scdpr calibrate`.
        begin: Where the end-effector rests, "0.3 m, 0.55 m".
        to: Where it is to go, "1.9 m, 0.55 m".
        out: The table to write, plan.csv; a page with the same name, plan.html, shows it.
        leg_time: Time of the leg, "2 s"; default: 2 s, or what the drives need.
        setting: Nominal pretension, "350 N"; default: the first of the tuning.
        force: Plan with a tuning whose fit has failed, too; the plan is marked.
    """
    beside = _page_beside(out)
    set_up()
    from experiments.reports import plan_report
    from experiments.studies.planned_leg import compare
    from experiments.verbs.places import parse_position
    from identification.campaign.quantities import parse_quantity
    from scdpr_jax.numerics.files import write_whole
    from tuning.plan.plan_file import write_plan
    from tuning.plan.planning import plan_leg
    from tuning.result.document import read_tuning

    tuned = read_tuning(tuning)
    if tuned.caution and not force:
        raise ValueError(f"{tuning}: {tuned.caution} `--force` plans all the same.")
    nominal = None if setting is None else parse_quantity(setting, unit="N", name="--setting")
    seconds = (
        None if leg_time is None else parse_quantity(leg_time, unit="s", name="--leg-time")
    )
    robot = tuned.robot_at(nominal).robot
    start, end = (
        parse_position(text, name=name, robot=robot)
        for text, name in ((begin, "--from"), (to, "--to"))
    )
    if start == end:
        raise ValueError(
            f"`--to`: got {to}, the same place as `--from`, expected another one: there is no "
            "leg to plan."
        )
    with shown_progress(ERRORS) as progress:
        inner, law = progress.part(0.0, 0.9), tuned.controller
        planned = plan_leg(robot, law, start, end, leg_time=seconds, progress=inner)
        progress("the leg beside the PD of Eq. (25) alone", 0.9)
        compared = compare(robot, tuned.controller, planned)
    limit = float(robot.drive.voltage_limit)
    write_plan(out, planned, marked=bool(tuned.caution))
    write_whole(
        beside,
        plan_report.plan_page(
            planned,
            compared,
            voltage_limit=limit,
            tuning=str(tuning),
            caution=tuned.caution,
        ),
    )
    status = ending(tuning, fits=not tuned.caution)
    plan_report.show(OUT, planned, compared, voltage_limit=limit, caution=tuned.caution)
    wrote(out, beside)
    suggest(f"open {beside}")
    return status


def _page_beside(out: pathlib.Path) -> pathlib.Path:
    """The page of a table."""
    page = out.with_suffix(".html")
    if page == out:
        raise ValueError(
            f"`--out`: got {out}, expected a table, such as {out.with_suffix('.csv')}: the "
            "page that shows it is written beside it."
        )
    return page
