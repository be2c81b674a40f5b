"""The README's picture: a leg as the paper drives it, and as planned. Writes `robot.svg`.

    python docs/readme_picture.py

The picture is committed, as a repository's page builds nothing; a test holds it to this.
"""

import pathlib

import numpy as np

from experiments.figures.before_after import Side, before_after
from experiments.figures.robot_film import Track
from experiments.runtime import set_up
from experiments.studies.legs.planned_leg import AFTERWARDS, compare
from scdpr_jax import Robot, consistent, exact, published_pd
from scdpr_jax.legs.leg import Leg
from tuning import plan_leg

START, END = (0.3, 0.3), (1.9, 0.3)
"""Where the leg begins and ends [m]."""
ROBOT = 4
"""Of the robots that a leg is planned for, `tuning.plan.expectation.ROBOTS`, the one shown: its
friction is 20 % higher than the plan has it, as no fit is perfect."""
PICTURE = pathlib.Path(__file__).with_name("robot.svg")


def picture() -> str:
    """The picture.

    Returns:
        An SVG file.
    """
    robot, controller = exact(consistent()), published_pd()
    planned = plan_leg(robot, controller, START, END)
    compared = compare(robot, controller, planned)
    return drawing(
        robot, compared.plain[ROBOT], compared.planned[ROBOT], leg_time=planned.leg.time
    )


def drawing(robot: Robot, before: Leg, after: Leg, *, leg_time: float) -> str:
    """The picture of two runs.

    Args:
        robot: The robot.
        before: The leg as the paper drives it.
        after: The planned one.
        leg_time: When they are to have arrived [s].

    Returns:
        An SVG file.
    """
    sides = [
        _side(title, run, leg_time + AFTERWARDS)
        for title, run in (("Before: as in the paper", before), ("After: as planned", after))
    ]
    return before_after(
        robot,
        sides,
        target=END[0],
        leg_time=leg_time,
        name=(
            "Two drawings of the cable robot that move 1.6 m to the right in 2 s, simulated "
            "with 20 % more friction than the plan knows. "
            + " ".join(f"{side.title}: {side.outcome}." for side in sides)
        ),
    )


def _side(title: str, run: Leg, last: float) -> Side:
    """A run until an instant, and what it leaves."""
    shown = run.time <= last
    track = Track(title, run.time[shown], np.asarray(run.states.position)[shown])
    swing = 1e3 * float(run.measures.residual_vibration)
    rest = 1e3 * abs(float(run.measures.resting_error))
    return Side(title, track, f"vibrates by {swing:.1f} mm, rests {rest:.1f} mm off")


if __name__ == "__main__":
    set_up()
    PICTURE.write_text(picture(), encoding="utf-8")
