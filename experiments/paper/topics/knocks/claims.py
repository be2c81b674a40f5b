"""Section 5.2: what the natural frequencies are said to be."""

import numpy as np

from experiments.paper.claim import Claim, Verdict, at_least, at_most, within
from experiments.paper.topics.knocks.numbers import fig11, fig12, level
from scdpr_jax.linear.modes import BOTH_HELD, PRINTED

_ABOUT = "“about”: a twentieth, as the two digits and the word bear"


def _nominal(setting: float) -> float:
    """First mode of (18) as printed at mid-height with the nominal tension [Hz]."""
    return level(PRINTED).nominal(setting)


def _rise_of_knocks() -> float:
    """Middle over outer rows of the simulated knocks [1]."""
    peaks = fig12().peaks
    return float(np.mean(peaks[:, 1:3]) / np.mean(peaks[:, [0, 3]]))


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "fig11",
        "5.2, Fig. 11",
        "next peak of the spectrum over the highest: “a clear single peak”",
        "one peak",
        "1",
        at_most(0.33),
        "a third of its height is clear",
        lambda: fig11().second,
        Verdict.REPRODUCED,
        "for a knock that leaves the carriages where they are",
        heavy=True,
    ),
    *(
        Claim(
            "fig12",
            "5.2, Fig. 12",
            f"natural frequency at {setting:.0f} N, knocks with T_eff = 0.243 of the nominal",
            printed,
            "Hz",
            within(float(printed), 0.05 * float(printed)),
            _ABOUT,
            lambda setting=setting: fig12().peak(setting),
            Verdict.AFTER_ERRATUM,
            "E22: an effective pretension, here the one that 50 mm of error ask for (E27)",
            heavy=True,
        )
        for setting, printed in ((200.0, "2.4"), (500.0, "3.9"))
    ),
    *(
        Claim(
            "fig12",
            "5.2, Fig. 12",
            f"natural frequency at {setting:.0f} N, (18) as printed with the nominal tension",
            printed,
            "Hz",
            within(float(printed), 0.05 * float(printed)),
            _ABOUT,
            lambda setting=setting: _nominal(setting),
            Verdict.NOT_REPRODUCIBLE,
            "E22: more than twice as high, whatever holds the carriages 1.2 times at least",
        )
        for setting, printed in ((200.0, "2.4"), (500.0, "3.9"))
    ),
    Claim(
        "fig12",
        "5.2, Fig. 12",
        "ratio of the two frequencies, √(500/200) by (20)",
        "3.9/2.4",
        "1",
        within(3.9 / 2.4, 0.05 * 3.9 / 2.4),
        "two numbers of two digits: 3 %, and “about”",
        lambda: fig12().peak(500.0) / fig12().peak(200.0),
        Verdict.REPRODUCED,
        "f ~ √T holds",
        heavy=True,
    ),
    Claim(
        "fig12",
        "5.2, Fig. 12",
        "highest at mid-height: middle over outer rows, (18) as printed",
        "> 1",
        "1",
        at_least(1.0),
        "higher is above one",
        lambda: level(PRINTED).rise,
        Verdict.REPRODUCED,
        "with both carriages free of drives and friction",
    ),
    Claim(
        "fig12",
        "5.2, Fig. 12",
        "highest at mid-height: middle over outer rows, carriages held by friction",
        "> 1",
        "1",
        at_least(1.0),
        "higher is above one",
        lambda: level(BOTH_HELD).rise,
        Verdict.NOT_REPRODUCIBLE,
        "E22: held carriages turn it round, yet they alone give frequencies and 50 mm at once",
    ),
    Claim(
        "fig12",
        "5.2, Fig. 12",
        "highest at mid-height: middle over outer rows of the simulated knocks",
        "> 1",
        "1",
        at_least(1.0),
        "higher is above one",
        _rise_of_knocks,
        Verdict.NOT_REPRODUCIBLE,
        "E22: friction of 4.5 N holds the carriages through knocks of 10 N",
        heavy=True,
    ),
)
"""Claims of section 5.2."""
