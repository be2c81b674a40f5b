r"""The search for a leg's motion: several first guesses, the best of which is refined.

What is to vanish is everything that a robot does after its leg, for a dozen robots as they
might be and from starts as they might be. While both carriages slide, friction is a constant
force and the state at the end is nearly linear in the motion; where the upper one stops and
starts on the way, the misfit has kinks, and a descent ends beside one of them. So there are
several: from the plain profile, and from the motions that suit robots of half and of one and a
half times the friction, which stop elsewhere. Random guesses, loose weights first, and the
fitted robot's own motion are no better as first guesses, and five are hardly better than three.
Which of them leads deepest shows after a dozen steps for the farthest robots alone: to follow
each to its end for all of them takes half as long again, and leaves a tenth less.
"""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.ensemble import Variation
from scdpr_jax.numerics.levenberg_marquardt import Damping, Minimum, Stopping, minimise
from scdpr_jax.robot.parameters import Robot
from tuning.plan.led.servo import servo
from tuning.plan.leg import Leg
from tuning.plan.search.grid import Grid
from tuning.plan.search.misfit import Misfit, Motion
from tuning.plan.search.scenarios import FARTHEST, FITTED, VARIATIONS, scenarios
from tuning.plan.search.team import Team, team

COARSE, FINE = 10e-3, 5e-3
"""Lengths of the steps, at the most, on which a guess and a result are found [s]."""
DAMPING = Damping(fall=5.0, rise=4.0, floor=1e-9)
"""Damping of a search; the floor is for splines that move almost nothing."""
REJECTIONS = 8
"""Dampings that are tried before a point counts as a minimum, or as a kink."""
GUESSES = (0.5, 1.5)
"""Friction forces over the fitted ones of robots whose motions are first guesses [1]."""


class Stage(NamedTuple):
    """A descent."""

    steps: int
    """Steps that help, at the most."""
    saving: float
    """Share of the misfit that a step has to save for another to follow [1]."""


FIRST = Stage(30, 1e-3)
"""For the fitted robot alone: what can be driven at once."""
GUESS = Stage(20, 1e-2)
"""A first guess."""
EXTREME = Stage(12, 2e-2)
"""From a guess, for the fitted robot and the farthest others."""
ALL = Stage(40, 1e-2)
"""For all robots, from the best of these."""
LAST = Stage(3, 1e-3)
"""The same on the fine grid."""


class Models(NamedTuple):
    """The robots that a search is for, under their PD."""

    fitted: Team
    """The fitted one alone."""
    guesses: tuple[Team, ...]
    """Those whose motions are first guesses, each alone."""
    farthest: Team
    """The fitted one and the farthest others."""
    every: Team
    """The fitted one and all others."""


def models(robot: Robot, controller: PD, *, told: bool) -> Models:
    """The robots that a search is for.

    Args:
        robot: The fitted one.
        controller: The PD beside the feed-forward.
        told: Whether the leg's start is known to be as it is.

    Returns:
        All of them.
    """
    own, fitted = servo(robot, controller), scenarios(robot, FITTED)
    others = scenarios(robot, VARIATIONS, told=told)
    farthest = jax.tree.map(lambda leaf: leaf[: len(FARTHEST)], others)
    guesses = (scenarios(robot, (Variation(friction=share),)) for share in GUESSES)
    return Models(
        team(fitted, None, own),
        tuple(team(guess, None, own) for guess in guesses),
        team(fitted, farthest, own),
        team(fitted, others, own),
    )


def search(about: Models, coarse: Grid, fine: Misfit) -> Float[np.ndarray, " splines"]:
    """The motion of a leg.

    Args:
        about: The robots that it is for.
        coarse: The leg on the steps that guesses are found on.
        fine: All robots on the steps that the result is found on.

    Returns:
        Coefficients of its splines [m].
    """
    plain = np.zeros(coarse.leg.splines)
    alone = (Misfit(guess, coarse) for guess in about.guesses)
    guesses = [plain, *(descend(own, plain, GUESS).point for own in alone)]
    farthest = Misfit(about.farthest, coarse)
    ends = (descend(farthest, guess, EXTREME) for guess in guesses)
    best = min(ends, key=lambda own: own.normal.cost)
    found = descend(Misfit(about.every, coarse), best.point, ALL)
    return descend(fine, found.point, LAST).point


def descend(
    misfit: Misfit, start: Float[np.ndarray, " splines"], stage: Stage
) -> Minimum[Motion]:
    """A descent.

    Args:
        misfit: What is to fall.
        start: Where it begins.
        stage: When it ends.

    Returns:
        The minimum that it leads to.
    """
    stopping = Stopping(
        steps=stage.steps, rejections=REJECTIONS, saving=stage.saving, share=0.0
    )
    return minimise(misfit, start, stopping=stopping, damping=DAMPING)


def stepped(leg: Leg, duration: float) -> Grid:
    """A leg in steps.

    Args:
        leg: The leg.
        duration: Length of the steps on the coarse grid at the most, of half of it on the fine.

    Returns:
        The leg on them.
    """
    coarse = int(np.ceil(leg.time / COARSE))
    return Grid(leg, coarse * round(COARSE / duration))
