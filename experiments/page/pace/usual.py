"""How verbs usually go, by the clock of a quiet machine, on campaigns of 5 to 14 runs."""

import dataclasses

from experiments.page.pace.clock import BEGUN, Detour, Pace

THE_WHOLE = ("calibrate", "demo")
"""What compiles all that the verbs of `USUAL` run, but for the comparison of models."""
MODELS = "models compared"
"""By what is known that the comparison of models has been compiled."""


@dataclasses.dataclass(frozen=True)
class Usual:
    """How a verb goes the first time on a machine, which compiles, and again."""

    first: Pace
    """The first time."""
    again: Pace
    """Again, with any campaign."""
    first_detour: Detour | None = None
    """Models compared the first time, after the fit of the usual one; None where none are."""
    detour: Detour | None = None
    """Models compared, again."""


def _pace(
    total: float, *points: tuple[float, float], belief: float = 0.02, origin: float = 0.0
) -> Pace:
    return Pace(total, points, belief=belief, origin=origin)


USUAL: dict[str, Usual] = {
    "identify": Usual(
        first=_pace(
            16.0, (BEGUN, 0.26), (0.131, 0.87), (0.288, 0.88), (0.316, 0.89), (0.4, 0.91)
        ),
        again=_pace(
            2.0,
            (BEGUN, 0.27),
            (0.131, 0.57),
            (0.288, 0.64),
            (0.316, 0.71),
            (0.344, 0.77),
            (0.4, 0.83),
        ),
        first_detour=Detour(
            0.4,
            0.985,
            _pace(
                20.0,
                (0.457, 0.45),
                (0.514, 0.53),
                (0.571, 0.58),
                (0.629, 0.63),
                (0.686, 0.7),
                (0.85, 0.73),
                (0.96, 0.74),
                (0.97, 0.84),
                (0.98, 0.9),
                origin=0.4,
            ),
        ),
        detour=Detour(
            0.4,
            0.985,
            _pace(
                8.0,
                (BEGUN, 0.06),
                (0.122, 0.13),
                (0.288, 0.32),
                (0.316, 0.36),
                (0.4, 0.385),
                (0.41, 0.4),
                (0.457, 0.45),
                (0.514, 0.515),
                (0.571, 0.59),
                (0.629, 0.7),
                (0.686, 0.755),
                (0.85, 0.785),
                (0.96, 0.79),
                (0.97, 0.86),
                (0.98, 0.915),
            ),
        ),
    ),
    "calibrate": Usual(
        first=_pace(
            60.0,
            (0.019, 0.07),
            (0.1, 0.38),
            (0.651, 0.43),
            (0.698, 0.44),
            (0.738, 0.52),
            (0.828, 0.57),
            (0.846, 0.64),
            (0.862, 0.77),
            (0.874, 0.8),
            (0.93, 0.87),
            (0.958, 0.95),
        ),
        again=_pace(
            18.0,
            (0.018, 0.06),
            (0.1, 0.1),
            (0.65, 0.13),
            (0.698, 0.15),
            (0.716, 0.24),
            (0.738, 0.28),
            (0.76, 0.31),
            (0.783, 0.34),
            (0.805, 0.37),
            (0.827, 0.41),
            (0.846, 0.53),
            (0.862, 0.57),
            (0.874, 0.72),
            (0.93, 0.76),
            (0.958, 0.83),
            (0.972, 0.93),
        ),
        first_detour=Detour(
            0.272,
            0.65,
            _pace(
                60.0,
                (0.308, 0.23),
                (0.344, 0.27),
                (0.452, 0.37),
                (0.651, 0.46),
                (0.698, 0.49),
                (0.716, 0.54),
                (0.738, 0.57),
                (0.828, 0.64),
                (0.846, 0.75),
                (0.862, 0.78),
                (0.874, 0.83),
                (0.93, 0.86),
                (0.958, 0.9),
                (0.972, 0.96),
                origin=0.272,
            ),
        ),
        detour=Detour(
            0.272,
            0.65,
            _pace(
                25.0,
                (0.018, 0.05),
                (0.096, 0.08),
                (0.2, 0.135),
                (0.272, 0.15),
                (0.344, 0.19),
                (0.452, 0.25),
                (0.65, 0.32),
                (0.698, 0.34),
                (0.716, 0.4),
                (0.738, 0.44),
                (0.76, 0.47),
                (0.783, 0.5),
                (0.805, 0.52),
                (0.827, 0.55),
                (0.846, 0.62),
                (0.862, 0.66),
                (0.874, 0.76),
                (0.93, 0.83),
                (0.958, 0.88),
                (0.972, 0.95),
            ),
        ),
    ),
    "tune": Usual(
        _pace(60.0, (0.1, 0.27), (0.7, 0.34), (0.8, 0.45), (0.89, 0.8), (0.95, 0.91)),
        _pace(13.0, (0.1, 0.06), (0.7, 0.21), (0.8, 0.37), (0.89, 0.63), (0.95, 0.97)),
    ),
    "plan": Usual(
        _pace(40.0, (0.12, 0.36), (0.54, 0.69), (0.6, 0.77)),
        _pace(3.0, (0.12, 0.36), (0.54, 0.69), (0.6, 0.77)),
    ),
    "plan --legs": Usual(_pace(57.0, (0.75, 0.89)), _pace(5.0, (0.75, 0.75))),
}
"""By a verb's name."""
