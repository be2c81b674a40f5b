"""`scdpr plan`: the references and the feed-forward of one leg."""

import os
import pathlib
from typing import TYPE_CHECKING, Annotated

import tyro

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import (
    ERRORS,
    OUT,
    Folder,
    open_call,
    say,
    suggest,
    tell_distrusted,
    wrote,
)
from experiments.verbs.failed_fit import ending
from experiments.verbs.places import parse_position, try_out
from experiments.verbs.starting_pose import beginning

if TYPE_CHECKING:
    from scdpr_jax.robot.parameters import Robot
    from tuning.plan.planning import Wanted
    from tuning.result.tuning import Tuning


def plan(
    tuning: Folder,
    /,
    out: pathlib.Path,
    begin: Annotated[str | None, tyro.conf.arg(name="from")] = None,
    to: str | None = None,
    start: str | None = None,
    start_run: pathlib.Path | None = None,
    legs: pathlib.Path | None = None,
    leg_time: str | None = None,
    setting: str | None = None,
    force: bool = False,
    cores: int | None = None,
    cluster: str | None = None,
    certificates: pathlib.Path | None = None,
) -> int:
    """Plan a leg that arrives without vibration: what the controller is to follow.

    The controller adds its PD on the pulleys' angles: V = Kp e + Kd de/dt + feedforward,
    within the drives' limit. Angles count from those at the leg's begin; the last row is
    held. A manoeuvre of several legs is one plan after the other, or a file of `--legs`.

    Args:
        tuning: tuning.json of `scdpr tune` or `scdpr calibrate`, or codesign.json of
            `scdpr codesign`.
        out: The table to write, plan.csv; a page with the same name, plan.html, shows it. With
            `--legs` a folder: a plan for each leg, and legs.csv with what is expected of it.
        begin: Where the end-effector rests, "0.3 m, 0.55 m"; the plan is made for any start
            that friction holds there.
        to: Where it is to go, "1.9 m, 0.55 m".
        start: In place of `--from`: how the robot stands, x_e, y_e, delta_e, q_3, q_4, "0.3 m,
            0.55 m, 0 rad, 0.302 m, 0.298 m".
        start_run: In place of `--from`: a run's folder; it starts as that one's camera saw it
            last.
        legs: In place of one leg: a table of them, with the columns x_from [m], y_from [m],
            x_to [m], y_to [m], leg_time [s] and, if known, slope [1], (q_3 - q_4) / H.
        leg_time: Time of the leg, "2 s"; default: 2 s. What the drives can't do takes longer.
        setting: Nominal pretension, "350 N"; default: the first of the tuning.
        force: Plan with a tuning whose fit has failed, too; the plan is marked.
        cores: With `--legs`: processes of this machine to share them among; default: one a
            core, or this one for few legs. A call that was stopped goes on where it was: give
            it again.
        cluster: With `--legs`: a dask cluster to share them among, tcp://HOST:PORT or
            tls://HOST:PORT, or local:N for one of N workers on this machine. Needs the extra
            `cluster`.
        certificates: Folder with ca.pem, cert.pem and key.pem, for tls://.
    """
    from experiments.runtime.executors.chosen import require_cluster

    require_cluster(cluster, certificates, cores)
    if legs is None and (cores is not None or cluster is not None):
        raise ValueError(
            "`--cluster` and `--cores` share `--legs` out, got one leg. Leave them out."
        )
    try_out(*((out, _page_beside(out)) if legs is None else (out / "legs.csv",)))
    set_up()
    from identification.campaign.quantities import parse_quantity
    from tuning.result.document import read_tuning

    tuned = read_tuning(tuning)
    if tuned.caution and not force:
        raise ValueError(f"{tuning}: {tuned.caution} `--force` plans all the same.")
    nominal = None if setting is None else parse_quantity(setting, unit="N", name="--setting")
    seconds = (
        None if leg_time is None else parse_quantity(leg_time, unit="s", name="--leg-time")
    )
    fitted = tuned.robot_at(nominal)
    if nominal is not None and fitted.pretension != nominal:
        say(f"note: {nominal:.7g} N is the tuned setting of {fitted.pretension:g} N.")
    robot = fitted.robot
    if legs is not None:
        given = {"--from": begin, "--to": to, "--start": start, "--leg-time": leg_time}
        given["--start-run"] = start_run
        if named := [name for name, own in given.items() if own is not None]:
            raise ValueError(
                f"`--legs` names its legs itself, got {', '.join(named)} besides, expected it "
                "alone. Leave either out."
            )
        return _many(tuning, tuned, robot, legs, out, (cluster, certificates, cores))
    if to is None:
        raise ValueError(
            '`--to` is missing: say where the end-effector is to go, such as "1.9 m, 0.55 m", '
            "or name a table of legs, `--legs`."
        )
    first = beginning(robot, begin, start, start_run)
    end = parse_position(to, name="--to", robot=robot)
    if first.place == end:
        raise ValueError(
            f"`--to`: got {to}, the same place as the start, expected another one: there is no "
            "leg to plan."
        )
    from tuning.plan.planning import Wanted

    return _one(tuning, tuned, robot, Wanted(first.place, end, seconds, first.slope), out)


def _one(
    tuning: pathlib.Path, tuned: "Tuning", robot: "Robot", wanted: "Wanted", out: pathlib.Path
) -> int:
    """A leg with the page that shows it."""
    from experiments.reports import plan_report
    from experiments.studies.legs.planned_leg import compare
    from scdpr_jax.numerics.files import write_whole
    from scdpr_jax.provenance import made_today
    from tuning.plan.plan_file import write_plan
    from tuning.plan.planning import plan_leg

    beside = _page_beside(out)
    with shown_progress(ERRORS, "plan") as progress:
        planned = plan_leg(
            robot,
            tuned.controller,
            wanted.start,
            wanted.end,
            leg_time=wanted.time,
            slope=wanted.slope,
            progress=progress.part(0.0, 0.6),
        )
        progress("the leg beside the PD of Eq. (25) alone", 0.6)
        compared = compare(robot, tuned.controller, planned)
    limit = float(robot.drive.voltage_limit)
    made = made_today(tuned.provenance.campaign, tuned.provenance.source)
    write_plan(out, planned.plan, marked=bool(tuned.caution), provenance=made)
    write_whole(
        beside,
        plan_report.plan_page(
            planned,
            compared,
            robot=robot,
            tuning=str(tuning),
            caution=tuned.caution,
        ),
    )
    status = ending(tuning, fits=not tuned.caution)
    plan_report.show(OUT, planned, compared, voltage_limit=limit, caution=tuned.caution)
    wrote(out, beside)
    suggest(open_call(beside))
    return status


def _many(
    tuning: pathlib.Path,
    tuned: "Tuning",
    robot: "Robot",
    legs: pathlib.Path,
    out: pathlib.Path,
    shared: "tuple[str | None, pathlib.Path | None, int | None]",
) -> int:
    """A table's legs, each in a file, and a table of what is expected of them."""
    from experiments.runtime.executors.chosen import chosen
    from experiments.studies.legs.many_legs import write_legs
    from experiments.studies.legs.unit import LEGS
    from tuning.plan.legs_file import read_legs

    wanted = read_legs(legs, robot)
    *elsewhere, cores = shared
    few = len(wanted) <= LEGS
    number = cores or (1 if few else os.cpu_count() or 1)
    with (
        shown_progress(ERRORS, "plan --legs") as progress,
        chosen(*elsewhere, number) as executor,
    ):
        written = write_legs(
            robot,
            tuned.controller,
            wanted,
            out,
            executor=executor,
            marked=bool(tuned.caution),
            provenance=tuned.provenance,
            distrusted=tell_distrusted,
            progress=progress,
        )
    say(
        f"{len(wanted)} legs planned; {written.longer} take longer than asked for, as the "
        f"drives can't do them in that time; {written.plain} are the plain profile, of which "
        "less vibration is expected.",
    )
    wrote(written.table)
    suggest(open_call(written.table))
    return ending(tuning, fits=not tuned.caution)


def _page_beside(out: pathlib.Path) -> pathlib.Path:
    """The page of a table."""
    page = out.with_suffix(".html")
    if page == out:
        raise ValueError(
            f"`--out`: got {out}, expected a table, such as {out.with_suffix('.csv')}: the "
            "page that shows it is written beside it."
        )
    return page
