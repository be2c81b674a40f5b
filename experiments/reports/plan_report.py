"""What is told of a planned leg: in the terminal and as a page."""

import numpy as np
from rich.console import Console

from experiments.figures.robot_film import Track, robot_film
from experiments.figures.tuning.leg import leg
from experiments.page.console_text import print_lines, print_table
from experiments.page.number_text import plain
from experiments.page.page import Pictures, page, versions
from experiments.page.table import Table
from experiments.studies.legs.planned_leg import SIDES, Compared
from scdpr_jax.legs.measures import SETTLED, LegMeasures
from scdpr_jax.robot.parameters import Robot
from tuning.plan.planning import Planned

_METHOD = (
    "A plan is the motion of the lower carriage and of the height, with the commands that it "
    "takes by dynamics inversion, friction included. The motion is found by least squares "
    "through the simulation with exact friction, so that everything comes to rest at the "
    "target at one moment: for the fitted robot and for the others of the table at once.",
    "Both legs are simulated at the controller's rate on the fitted nonlinear robot: the "
    "plain one with the curve of section 6.2 in the plan's time under the PD of Eq. (25), "
    "the plan under its own gains. After the reference's end it is held.",
    "The resting error is that of the line between the carriages, on which the end-effector "
    "comes to rest. The largest error is against each leg's own reference, Eq. (26).",
)


def sentences(
    planned: Planned, compared: Compared, *, voltage_limit: float, caution: str = ""
) -> list[str]:
    """What a plan comes to, in plain words.

    Args:
        planned: The plan.
        compared: Its runs.
        voltage_limit: Largest command of either sign [V].
        caution: What its tuning warns of; empty for nothing.

    Returns:
        Sentences.
    """
    plan = planned.plan
    before, after = compared.plain[0].measures, compared.planned[0].measures
    left = [run.measures.residual_vibration for run in compared.planned]
    worst = int(np.argmax(left))
    lines = [
        *filter(None, [caution]),
        f"In {plain(plan.time[-1], 3)} s from {_place(plan.position[0])} to "
        f"{_place(plan.position[-1])}: after it the end-effector vibrates "
        f"{_mm(after.residual_vibration)} mm and rests {_mm(after.resting_error)} mm from "
        f"the target, against {_mm(before.residual_vibration)} mm and "
        f"{_mm(before.resting_error)} mm by the plain profile.",
        f"Of the robots that it was made for, that which vibrates the most does so by "
        f"{_mm(left[worst])} mm ({compared.names[worst]}).",
    ]
    if planned.leg.time > planned.asked_time:
        lines.append(
            f"It takes {plain(plan.time[-1], 3)} s, not {plain(planned.asked_time, 3)} s: in "
            "the time that was asked for the drives can't bring everything to rest."
        )
    if planned.is_plain:
        lines.append(
            "It is the plain profile without feed-forward: over the robots below the planned "
            "motion is expected to leave more."
        )
    if max(run.measures.largest_voltage for run in compared.planned) >= voltage_limit:
        lines.append(
            f"SHORT of what is asked: the drives come to their limit of {voltage_limit:g} V, "
            "and a saturated drive doesn't follow. Give the leg more time, `--leg-time`."
        )
    return lines


def tables(compared: Compared) -> tuple[Table, Table]:
    """The leg on the fitted robot, and what is left on others.

    Args:
        compared: Its runs.

    Returns:
        Two tables.
    """
    fitted = Table(
        "The leg, simulated on the fitted robot",
        (
            "",
            "vibration after it [mm]",
            "resting error [mm]",
            f"within {1e3 * SETTLED:g} mm from [s]",
            "largest error, Eq. (26) [mm]",
            "largest command [V]",
        ),
        tuple(
            (name, *_cells(runs[0].measures))
            for name, runs in zip(SIDES, (compared.plain, compared.planned), strict=True)
        ),
        spare=((3,),),
    )
    others = Table(
        "Robots as they might be",
        (
            "robot",
            "vibration, plain [mm]",
            "planned [mm]",
            "resting error, plain [mm]",
            "planned [mm]",
        ),
        tuple(
            (
                name,
                _mm(before.measures.residual_vibration),
                _mm(after.measures.residual_vibration),
                _mm(before.measures.resting_error),
                _mm(after.measures.resting_error),
            )
            for name, before, after in zip(
                compared.names, compared.plain, compared.planned, strict=True
            )
        ),
    )
    return fitted, others


def show(
    console: Console,
    planned: Planned,
    compared: Compared,
    *,
    voltage_limit: float,
    caution: str = "",
) -> None:
    """Print what a plan comes to.

    Args:
        console: Where to print it.
        planned: The plan.
        compared: Its runs.
        voltage_limit: Largest command of either sign [V].
        caution: What its tuning warns of; empty for nothing.
    """
    for table in tables(compared):
        print_table(console, table)
    told = sentences(planned, compared, voltage_limit=voltage_limit, caution=caution)
    print_lines(console, told)


def plan_page(
    planned: Planned, compared: Compared, *, robot: Robot, tuning: str, caution: str = ""
) -> str:
    """A plan as a page that needs nothing else.

    Args:
        planned: The plan.
        compared: Its runs.
        robot: The fitted robot.
        tuning: Name of the tuning that it is for.
        caution: What that warns of; empty for nothing.

    Returns:
        HTML.
    """
    plan, voltage_limit = planned.plan, float(robot.drive.voltage_limit)
    begun, ended = _place(plan.position[0]), _place(plan.position[-1])
    before, after = (
        Track(name, np.asarray(runs[0].time), np.asarray(runs[0].states.position))
        for name, runs in zip(SIDES, (compared.plain, compared.planned), strict=True)
    )
    return page(
        "findings.html.j2",
        title=f"Leg from {begun} to {ended}",
        sentences=sentences(planned, compared, voltage_limit=voltage_limit, caution=caution),
        tables=tables(compared),
        film=(
            robot_film(robot, after, name="film", ghost=before),
            "The leg on the fitted robot, to scale and in real time; dashed the end-effector "
            "under the plain profile. Red: its path.",
        ),
        pictures=[
            Pictures()(
                leg(compared, leg_time=float(plan.time[-1]), voltage_limit=voltage_limit),
                "The leg on the fitted robot: the distance covered along the straight line, "
                "the distance from the target around the end of the reference (dotted), and "
                "the commands of both drives. The last panel: the vibration after the leg "
                "on robots that differ from it.",
            ),
        ],
        method=_METHOD,
        provenance=[
            ("tuning", tuning),
            ("samples", f"{plan.time.size}, every {1e3 * (plan.time[1] - plan.time[0]):g} ms"),
            *versions(),
        ],
    )


def _cells(leg: LegMeasures) -> tuple[str, ...]:
    return (
        _mm(leg.residual_vibration),
        _mm(leg.resting_error),
        "never" if np.isnan(leg.settling_time) else f"{leg.settling_time:.3f}",
        f"{1e3 * leg.largest_original_error:.1f}",
        f"{leg.largest_voltage:.2f}",
    )


def _mm(length: float | np.ndarray) -> str:
    return f"{1e3 * length:.2f}"


def _place(position: np.ndarray) -> str:
    return f"({position[0]:.3g} m, {position[1]:.3g} m)"
