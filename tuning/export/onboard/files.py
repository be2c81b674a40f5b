"""`export/onboard/`: the planner, an example, a self-test, and how to call them."""

import math

import numpy as np

from scdpr_jax.legs.starts import held_slope
from tuning.export.description import decimal
from tuning.export.onboard.program import HEADER, SOURCE, OnBoard
from tuning.export.template import fill_in
from tuning.plan.planning import Planned, Wanted, plan_legs

FOLDER = "onboard"
"""Name of the folder within the exports."""
_INSTANTS = 9
"""Instants of a leg that the self-test looks at."""


def onboard_files(about: OnBoard) -> dict[str, str]:
    """The files of a planner on board.

    Args:
        about: The robot and its controller.

    Returns:
        Texts by name.
    """
    wanted = _legs(about)
    made = plan_legs(about.robot, about.controller, wanted)
    legs = [_row(about, *pair) for pair in zip(wanted, made, strict=True)]
    first = wanted[0]
    controller, header = about.controller, about.header()
    size = str(1000 * int(header.split("some ")[1].split(" kB")[0]))
    caution = f"\n\n**{about.about}**" if about.about else ""
    return {
        HEADER: header,
        SOURCE: about.source(),
        "example.c": fill_in(
            f"{FOLDER}/example.c",
            state=", ".join(map(decimal, _state(about, first))),
            x=decimal(first.end[0]),
            y=decimal(first.end[1]),
            time=decimal(first.time),
        ),
        "selftest.c": fill_in(
            f"{FOLDER}/selftest.c", instants=str(_INSTANTS), legs=",\n".join(legs)
        ),
        "README.md": fill_in(
            f"{FOLDER}/README.md",
            caution=caution,
            legs=str(len(legs)),
            period=decimal(controller.period),
            limit=decimal(about.robot.drive.voltage_limit),
            proportional=decimal(controller.proportional_gain),
            derivative=decimal(controller.derivative_gain),
            bytes=size,
        ),
    }


def _legs(about: OnBoard) -> list[Wanted]:
    """Legs of the self-test: across the frame, slantwise, and from a start out of line."""
    frame = about.robot.frame
    width, height = float(frame.width), float(frame.height)
    held = float(held_slope(about.robot))

    def place(x: float, y: float) -> tuple[float, float]:
        return round(x * width, 3), round(y * height, 3)

    return [
        Wanted(place(0.2, 0.5), place(0.7, 0.5), 2.5),
        Wanted(place(0.7, 0.3), place(0.3, 0.7), 3.0),
        Wanted(place(0.4, 0.6), place(0.6, 0.4), 2.0, 0.4 * held),
    ]


def _state(about: OnBoard, wanted: Wanted) -> list[float]:
    """How the robot rests, as `scdpr_leg_begin` is told it."""
    (x, y), slope = wanted.start, wanted.slope or 0.0
    height = float(about.robot.frame.height)
    return [x, math.atan(slope), x + slope * y, x - slope * (height - y), y]


def _row(about: OnBoard, wanted: Wanted, made: Planned) -> str:
    """A leg as a row of the self-test's table."""
    plan = made.plan
    rows = [
        np.array([plan.time[k], *plan.angle[k], *plan.feedforward[k]])
        for k in np.linspace(0, plan.time.size - 1, _INSTANTS).astype(int)
    ]
    state, end = (", ".join(map(repr, own)) for own in (_state(about, wanted), wanted.end))
    head = f"    {{{{{state}}}, {end}, {wanted.time!r}, {made.leg.time!r},"
    text = ",\n      ".join("{" + ", ".join(repr(float(x)) for x in row) + "}" for row in rows)
    return f"{head}\n     {{{text}}}}}"
