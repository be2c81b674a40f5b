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
from scdpr_jax import consistent, exact, published_pd
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
    last = planned.leg.time + AFTERWARDS
    sides = []
    for title, runs in (
        ("Before: as in the paper", compared.plain),
        ("After: as planned", compared.planned),
    ):
        run = runs[ROBOT]
        shown = run.time <= last
        track = Track(title, run.time[shown], np.asarray(run.states.position)[shown])
        swing = 1e3 * float(run.measures.residual_vibration)
        rest = 1e3 * abs(float(run.measures.resting_error))
        sides.append(Side(title, track, f"vibrates by {swing:.1f} mm, rests {rest:.1f} mm off"))
    return before_after(
        robot,
        sides,
        target=END[0],
        leg_time=planned.leg.time,
        name=(
            "Two drawings of the cable robot that move 1.6 m to the right in 2 s, simulated "
            "with 20 % more friction than the plan knows. "
            + " ".join(f"{side.title}: {side.outcome}." for side in sides)
        ),
    )


if __name__ == "__main__":
    set_up()
    PICTURE.write_text(picture(), encoding="utf-8")
