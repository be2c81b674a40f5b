"""Section 5.2: what the natural frequencies are said to be."""

import numpy as np

from experiments.paper.claim import Claim, Printed, at_least, at_most, within
from experiments.paper.topics.knocks.numbers import fig11, fig12, level
from scdpr_jax.linear.modes import BOTH_HELD, PRINTED

_ABOUT = "“about”: a twentieth, as the two digits and the word bear"


def _rise_of_knocks() -> float:
    """Middle over outer rows of the simulated knocks [1]."""
    peaks = fig12().peaks
    return float(np.mean(peaks[:, 1:3]) / np.mean(peaks[:, [0, 3]]))


_LEVELS = {
    200.0: Printed("5.2, Fig. 12", "2.4", "Hz", within(2.4, 0.05 * 2.4), _ABOUT),
    500.0: Printed("5.2, Fig. 12", "3.9", "Hz", within(3.9, 0.05 * 3.9), _ABOUT),
}
_HIGHER = Printed("5.2, Fig. 12", "> 1", "1", at_least(1.0), "higher is above one")

FIG11: tuple[Claim, ...] = (
    Printed(
        "5.2, Fig. 11", "one peak", "1", at_most(0.33), "a third of its height is clear"
    ).reproduced(
        "next peak of the spectrum over the highest: “a clear single peak”",
        lambda: fig11().second,
        "for a knock that leaves the carriages where they are",
        heavy=True,
    ),
)
"""Claims on one knock."""

FIG12: tuple[Claim, ...] = (
    *(
        reported.after_erratum(
            f"natural frequency at {setting:.0f} N, knocks with T_eff = 0.243 of the nominal",
            lambda setting=setting: fig12().peak(setting),
            "E22: an effective pretension, here the one that 50 mm of error ask for (E27)",
            heavy=True,
        )
        for setting, reported in _LEVELS.items()
    ),
    *(
        reported.not_reproducible(
            f"natural frequency at {setting:.0f} N, (18) as printed with the nominal tension",
            lambda setting=setting: level(PRINTED).nominal(setting),
            "E22: more than twice as high, whatever holds the carriages 1.2 times at least",
        )
        for setting, reported in _LEVELS.items()
    ),
    Printed(
        "5.2, Fig. 12",
        "3.9/2.4",
        "1",
        within(3.9 / 2.4, 0.05 * 3.9 / 2.4),
        "two numbers of two digits: 3 %, and “about”",
    ).reproduced(
        "ratio of the two frequencies, √(500/200) by (20)",
        lambda: fig12().peak(500.0) / fig12().peak(200.0),
        "f ~ √T holds",
        heavy=True,
    ),
    _HIGHER.reproduced(
        "highest at mid-height: middle over outer rows, (18) as printed",
        lambda: level(PRINTED).rise,
        "with both carriages free of drives and friction",
    ),
    _HIGHER.not_reproducible(
        "highest at mid-height: middle over outer rows, carriages held by friction",
        lambda: level(BOTH_HELD).rise,
        "E22: held carriages turn it round, yet they alone give frequencies and 50 mm at once",
    ),
    _HIGHER.not_reproducible(
        "highest at mid-height: middle over outer rows of the simulated knocks",
        _rise_of_knocks,
        "E22: friction of 4.5 N holds the carriages through knocks of 10 N",
        heavy=True,
    ),
)
"""Claims on the natural frequency over the workspace."""
