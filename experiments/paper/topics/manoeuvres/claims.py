"""Section 6.2: what the controlled manoeuvres are said to be."""

import numpy as np

from experiments.paper.claim import AS_PRINTED, Claim, Verdict, at_least, digits, within
from experiments.paper.topics.manoeuvres.numbers import (
    BOTH_LEGS,
    GRAVITY,
    NAMES,
    ONE_LEG,
    tracked,
)
from experiments.paper.topics.prototype.numbers import derived_consistently
from scdpr_jax.command.trajectory import TABLE_3_LEG_TIMES, table_3

_ABOUT_50 = "“about”: a tenth"
_ABOUT_8 = "“about” one digit: 1 mm"
_TILT = "the vision system's angle: 2 mrad, three times"
_POSES = {
    "horizontal": ("0.3", "0.55", "1.9", "0.55"),
    "vertical": ("0.55", "0.20", "0.55", "0.9"),
    "diagonal": ("2.08", "0.92", "0.01", "0.19"),
}


def _pose(name: str, index: int) -> float:
    manoeuvre = getattr(table_3(), name)
    points = np.asarray(manoeuvre.legs[0].control_points)
    return float(points[[0, -1]].ravel()[index])


def _error(
    name: str, leg_time: float, tension: float | None = None, gravity: float = 0.0
) -> float:
    return 1e3 * float(tracked(name, leg_time, tension, gravity).error.max())


def _tilt(name: str, leg_time: float) -> float:
    return float(np.rad2deg(tracked(name, leg_time).tilt))


def _given(name: str) -> tuple[Claim, ...]:
    parts = ("initial x", "initial y", "intermediate x", "intermediate y")
    poses = tuple(
        Claim(
            "table3",
            "Table 3",
            f"{part} of the {name} manoeuvre",
            text,
            "m",
            digits(text),
            AS_PRINTED,
            lambda index=index: _pose(name, index),
            Verdict.GIVEN,
        )
        for index, (part, text) in enumerate(zip(parts, _POSES[name], strict=True))
    )
    time = Claim(
        "table3",
        "Table 3",
        f"time of the {name} manoeuvre",
        f"{ONE_LEG[name]:g}",
        "s",
        digits(f"{ONE_LEG[name]:g}"),
        AS_PRINTED,
        lambda: TABLE_3_LEG_TIMES[NAMES.index(name)],
        Verdict.GIVEN,
        "of one leg or of both: E16, E27",
    )
    return (*poses, time)


CLAIMS: tuple[Claim, ...] = (
    *(claim for name in NAMES for claim in _given(name)),
    Claim(
        "table3",
        "Table 3",
        "the diagonal's intermediate x lies in the workspace (1)",
        "0.01",
        "m",
        at_least(0.287 / 2),
        "half a carriage",
        lambda: _pose("diagonal", 2),
        Verdict.NOT_REPRODUCIBLE,
        "E17: (1) needs 0.1435 m",
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, horizontal, Table 3's time for both legs, T_eff = 85 N",
        "50",
        "mm",
        within(50.0, 5.0),
        _ABOUT_50,
        lambda: _error("horizontal", BOTH_LEGS["horizontal"]),
        Verdict.AFTER_ERRATUM,
        "E22, E27: 85 N is fitted to it",
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, horizontal, Table 3's time for one leg, T_eff = 85 N",
        "50",
        "mm",
        within(50.0, 5.0),
        _ABOUT_50,
        lambda: _error("horizontal", ONE_LEG["horizontal"]),
        Verdict.NOT_REPRODUCIBLE,
        "E27: 25 mm",
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, horizontal, time for both legs, the nominal 350 N",
        "50",
        "mm",
        within(50.0, 5.0),
        _ABOUT_50,
        lambda: _error("horizontal", BOTH_LEGS["horizontal"], 350.0),
        Verdict.NOT_REPRODUCIBLE,
        "E27: 20 mm",
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2",
        "commanded acceleration where the horizontal error is largest, over its largest",
        "accelerating",
        "1",
        at_least(0.5),
        "the larger half",
        lambda: tracked("horizontal", BOTH_LEGS["horizontal"]).pushed,
        Verdict.REPRODUCED,
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, vertical, time for both legs, gravity on",
        "8",
        "mm",
        within(8.0, 1.0),
        _ABOUT_8,
        lambda: _error("vertical", BOTH_LEGS["vertical"], None, GRAVITY),
        Verdict.AFTER_ERRATUM,
        "E31: with the weight that the paper leaves out",
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, vertical, time for both legs, no gravity",
        "8",
        "mm",
        within(8.0, 1.0),
        _ABOUT_8,
        lambda: _error("vertical", BOTH_LEGS["vertical"]),
        Verdict.NOT_REPRODUCIBLE,
        "E31: 5.7 mm",
        heavy=True,
    ),
    Claim(
        "fig18",
        "6.2, Fig. 18",
        "largest error, vertical, time for one leg, no gravity",
        "8",
        "mm",
        within(8.0, 1.0),
        _ABOUT_8,
        lambda: _error("vertical", ONE_LEG["vertical"]),
        Verdict.NOT_REPRODUCIBLE,
        "E31: 2.8 mm",
        heavy=True,
    ),
    Claim(
        "fig19",
        "6.2, Fig. 19",
        "largest rotation of all manoeuvres: the horizontal one at 2 s a leg",
        "3.2",
        "°",
        within(3.2, 0.35),
        _TILT,
        lambda: _tilt("horizontal", BOTH_LEGS["horizontal"]),
        Verdict.AFTER_ERRATUM,
        "E27: at the 85 N that 50 mm ask for",
        heavy=True,
    ),
    Claim(
        "fig19",
        "6.2, Fig. 19",
        "largest rotation of the diagonal manoeuvre at 2.5 s a leg",
        "3.2",
        "°",
        within(3.2, 0.35),
        _TILT,
        lambda: _tilt("diagonal", ONE_LEG["diagonal"]),
        Verdict.NOT_REPRODUCIBLE,
        "E27: 2.5° at 85 N, 3.1° at 75 N",
        heavy=True,
    ),
    Claim(
        "fig20",
        "6.2, Fig. 20",
        "command of the diagonal in mid-leg, time for one leg",
        "near 10",
        "V",
        within(10.0, 0.5),
        "“near”: a twentieth",
        lambda: derived_consistently().diagonal_voltage,
        Verdict.AFTER_ERRATUM,
        "E1, E16: with r = 73 mm",
    ),
    Claim(
        "fig20",
        "6.2, Fig. 20",
        "command of the diagonal in mid-leg, time for both legs",
        "near 10",
        "V",
        within(10.0, 0.5),
        "“near”: a twentieth",
        lambda: 2 * derived_consistently().diagonal_voltage,
        Verdict.NOT_REPRODUCIBLE,
        "E16: 20 V, twice what the drives take",
    ),
)
"""Claims of section 6.2."""
