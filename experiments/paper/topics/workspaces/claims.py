"""Sections 2.1 and 2.4: what the workspaces are said to be."""

import math

from experiments.paper.claim import Claim, Printed, within
from experiments.paper.topics.workspaces.numbers import workspaces


def _one_maximum() -> float:
    """The share that T_min = 10 N has at the T_max that T_min = 50 N asks for, per cent."""
    robots = workspaces()
    crossed = [robots.of(crossed=True, minimum=minimum) for minimum in (10.0, 50.0)]
    return 100 * crossed[0].share(crossed[1].maximum_for(0.4156))


_SHARE = Printed("2.1", "70.73", "%", within(70.73, 1.0), "a per cent: the grid and the border")

FIG3: tuple[Claim, ...] = (
    _SHARE.not_reproducible(
        "share of the frame for T_min = 10 N, cables open, whatever T_max",
        lambda: 100 * workspaces().of(crossed=False, minimum=10.0).share(math.inf),
        "E28: open cables hold 66 % of the frame at most, with any T_max; T_max isn't printed",
    ),
    _SHARE.not_reproducible(
        "share of the frame for T_min = 10 N at the T_max that gives 41.56 % at 50 N, crossed",
        _one_maximum,
        "E28: crossed cables need 93 N for the one and 151 N for the other; one T_max gives "
        "never both",
    ),
    Printed(
        "2.1",
        "41.56",
        "%",
        within(41.56, 1.0),
        "a per cent: T_max to a newton moves it by a third of that",
    ).after_erratum(
        "share of the frame for T_min = 50 N, cables open, T_max chosen as 287 N",
        lambda: 100 * workspaces().of(crossed=False, minimum=50.0).share(287.0),
        "E28: T_max isn't printed; this is the one that gives the figure",
    ),
)
"""Claims on the conventional robot's workspace."""

FIG6: tuple[Claim, ...] = (
    Printed(
        "2.4", "> 70.73", "%", (70.73, 100.0), "a gain is more than what is gained upon"
    ).not_reproducible(
        "share of the frame that expression (1) gives, to be above the conventional 70.73 %",
        lambda: 100 * workspaces().loop_share,
        "E29: (1) with Table 1 is 65.1 % of the frame's area",
    ),
    Printed("2.4", "almost all", "%", (95.0, 100.0), "almost all, read as 95 %").reproduced(
        "share of the poses inside the frame, “almost all”",
        lambda: 100 * workspaces().loop_reachable,
        "tensions don't limit it; a carriage as wide as the end-effector takes nothing away",
    ),
)
"""Claims on the single loop's workspace."""
