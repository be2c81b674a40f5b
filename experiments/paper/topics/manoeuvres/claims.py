"""Section 6.2: what the controlled manoeuvres are said to be."""

import numpy as np

from experiments.paper.claim import Claim, Printed, at_least, within
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
        Printed("Table 3", text, "m").given(
            f"{part} of the {name} manoeuvre", lambda index=index: _pose(name, index)
        )
        for index, (part, text) in enumerate(zip(parts, _POSES[name], strict=True))
    )
    time = Printed("Table 3", f"{ONE_LEG[name]:g}", "s").given(
        f"time of the {name} manoeuvre",
        lambda: TABLE_3_LEG_TIMES[NAMES.index(name)],
        "of one leg or of both: E16, E27",
    )
    return (*poses, time)


_HORIZONTAL = Printed("6.2, Fig. 18", "50", "mm", within(50.0, 5.0), _ABOUT_50)
_VERTICAL = Printed("6.2, Fig. 18", "8", "mm", within(8.0, 1.0), _ABOUT_8)
_ROTATION = Printed("6.2, Fig. 19", "3.2", "°", within(3.2, 0.35), _TILT)
_COMMAND = Printed("6.2, Fig. 20", "near 10", "V", within(10.0, 0.5), "“near”: a twentieth")

TABLE3: tuple[Claim, ...] = (
    *(claim for name in NAMES for claim in _given(name)),
    Printed("Table 3", "0.01", "m", at_least(0.287 / 2), "half a carriage").not_reproducible(
        "the diagonal's intermediate x lies in the workspace (1)",
        lambda: _pose("diagonal", 2),
        "E17: (1) needs 0.1435 m",
    ),
)
"""Claims on the manoeuvres' poses and times."""

FIG18: tuple[Claim, ...] = (
    _HORIZONTAL.after_erratum(
        "largest error, horizontal, Table 3's time for both legs, T_eff = 85 N",
        lambda: _error("horizontal", BOTH_LEGS["horizontal"]),
        "E22, E27: 85 N is fitted to it",
        heavy=True,
    ),
    _HORIZONTAL.not_reproducible(
        "largest error, horizontal, Table 3's time for one leg, T_eff = 85 N",
        lambda: _error("horizontal", ONE_LEG["horizontal"]),
        "E27: 25 mm",
        heavy=True,
    ),
    _HORIZONTAL.not_reproducible(
        "largest error, horizontal, time for both legs, the nominal 350 N",
        lambda: _error("horizontal", BOTH_LEGS["horizontal"], 350.0),
        "E27: 20 mm",
        heavy=True,
    ),
    Printed("6.2", "accelerating", "1", at_least(0.5), "the larger half").reproduced(
        "commanded acceleration where the horizontal error is largest, over its largest",
        lambda: tracked("horizontal", BOTH_LEGS["horizontal"]).pushed,
        heavy=True,
    ),
    _VERTICAL.after_erratum(
        "largest error, vertical, time for both legs, gravity on",
        lambda: _error("vertical", BOTH_LEGS["vertical"], None, GRAVITY),
        "E31: with the weight that the paper leaves out",
        heavy=True,
    ),
    _VERTICAL.not_reproducible(
        "largest error, vertical, time for both legs, no gravity",
        lambda: _error("vertical", BOTH_LEGS["vertical"]),
        "E31: 5.7 mm",
        heavy=True,
    ),
    _VERTICAL.not_reproducible(
        "largest error, vertical, time for one leg, no gravity",
        lambda: _error("vertical", ONE_LEG["vertical"]),
        "E31: 2.8 mm",
        heavy=True,
    ),
)
"""Claims on the tracking error."""

FIG19: tuple[Claim, ...] = (
    _ROTATION.after_erratum(
        "largest rotation of all manoeuvres: the horizontal one at 2 s a leg",
        lambda: _tilt("horizontal", BOTH_LEGS["horizontal"]),
        "E27: at the 85 N that 50 mm ask for",
        heavy=True,
    ),
    _ROTATION.not_reproducible(
        "largest rotation of the diagonal manoeuvre at 2.5 s a leg",
        lambda: _tilt("diagonal", ONE_LEG["diagonal"]),
        "E27: 2.5° at 85 N, 3.1° at 75 N",
        heavy=True,
    ),
)
"""Claims on the rotation."""

FIG20: tuple[Claim, ...] = (
    _COMMAND.after_erratum(
        "command of the diagonal in mid-leg, time for one leg",
        lambda: derived_consistently().diagonal_voltage,
        "E1, E16: with r = 73 mm",
    ),
    _COMMAND.not_reproducible(
        "command of the diagonal in mid-leg, time for both legs",
        lambda: 2 * derived_consistently().diagonal_voltage,
        "E16: 20 V, twice what the drives take",
    ),
)
"""Claims on the commands."""
