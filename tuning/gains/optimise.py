"""Gains and a shaper optimised over random legs, through the simulated closed loop.

Landing without vibration is no smooth problem: where a carriage sticks depends on everything
before, so a design that is best on a few legs leaves others as they were. Over a score of legs,
each of another robot, the mean is smooth enough for a search by sampling (cross entropy) in six
numbers. A gradient through the simulation isn't worth its compilation here.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.gains.cross_entropy import cross_entropy
from tuning.gains.design import (
    LONGEST,
    SPREAD,
    controller_of,
    design_of,
    flat,
    searched_from,
    shaper_of,
)
from tuning.gains.legs import IMPULSES, Law, Legs, at_period
from tuning.gains.loss import loss
from tuning.gains.outcome import outcome
from tuning.loop.admissible import Admissible
from tuning.result.prediction import LegsOutcome


class Effort(NamedTuple):
    """How much is spent on a search."""

    legs: int = 96
    """Random legs that a design is tried on."""
    population: int = 12
    """Designs of a generation."""
    generations: int = 5
    """Generations."""
    planned: int = 12
    """Random legs that are planned, too, to say what plans would leave."""


class Optimum(NamedTuple):
    """Where an optimisation ended."""

    controller: PD
    """Gains at the controller's own period."""
    shaper: Shaper
    """The shaper."""
    loss: float
    """Loss over the legs [1], see `tuning.gains.loss.loss`."""


def optimise(
    legs: Legs,
    within: Admissible,
    *,
    before: LegsOutcome,
    frequency: float,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    seed: int = 0,
    progress: Progress = SILENT,
) -> Optimum:
    """Gains and a shaper for random legs, through the simulated closed loop.

    Args:
        legs: The legs with their robots.
        within: Which gains are admissible.
        before: What the legs come to under Eq. (25) alone.
        frequency: Natural frequency that the shaper is for [Hz].
        effort: How much is spent.
        seed: Of the search's random numbers; the same seed finds the same design.
        progress: Told what is being done and which share of it is done.

    Returns:
        The best design seen.
    """

    def losses(
        designs: Float[np.ndarray, "population n"],
    ) -> Float[np.ndarray, " population"]:
        crossed = len(designs), len(legs)
        laws = jax.tree.map(
            lambda leaf: np.repeat(np.asarray(leaf), crossed[1], axis=0),
            _laws(designs, within),
        )
        tasks = legs.rows(np.tile(np.arange(crossed[1]), crossed[0]))
        return loss(outcome(tasks, laws).map(lambda own: own.reshape(crossed)), before)

    search = cross_entropy(
        losses,
        flat(searched_from(frequency)),
        np.diag(np.square(flat(SPREAD))),
        population=effort.population,
        generations=effort.generations,
        seed=seed,
        progress=progress,
    )
    best = design_of(search.best)
    return Optimum(controller_of(within, best), shaper_of(best), search.loss)


def scaled(shaper: Shaper, pace: float) -> Shaper:
    """A shaper made longer, up to `LONGEST`.

    Args:
        shaper: The shaper.
        pace: By how much longer [1].

    Returns:
        The same amplitudes at other times.
    """
    duration = float(shaper.duration)
    longer = min(pace, LONGEST / duration) if duration > 0 else 1.0
    return Shaper(longer * np.asarray(shaper.times), np.asarray(shaper.amplitudes))


@jax.jit
def _laws(designs: Float[Array, "population n"], within: Admissible) -> Law:
    """Controllers at the search's period, and shapers, of flat designs."""

    def law(numbers: Float[Array, " n"]) -> Law:
        design = design_of(numbers)
        shaper = shaper_of(design)
        idle = IMPULSES - shaper.times.size
        room = Shaper(
            jnp.pad(shaper.times, (0, idle), mode="edge"), jnp.pad(shaper.amplitudes, (0, idle))
        )
        return Law(at_period(controller_of(within, design)), room)

    return jax.vmap(law)(designs)
