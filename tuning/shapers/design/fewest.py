"""A shaper's impulses made fewer, as long as it leaves hardly more.

Where many shapers leave next to nothing, the convex program's minimum has an impulse at every
other instant, of which most do nothing that a camera could see. Impulses are taken out one by
one, by leaving one out or by merging two neighbours, and what is left is refined; exact, and
dearer by far, would be to try every subset.
"""

import itertools
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.design.criterion import Criterion
from tuning.shapers.design.positive import Design
from tuning.shapers.design.refine import IMPULSES, refined

_LEAST = 2
"""Impulses below which a shaper is none."""
_REFINED = 2
"""Ways of taking out an impulse that are refined: those that leave least at once."""


def fewest_impulses(
    criterion: Criterion, design: Design, *, bound: float, most: int = IMPULSES
) -> Design:
    """A design of no longer duration with the fewest impulses that keep a bound.

    Args:
        criterion: What the design leaves little of.
        design: The design, of positive impulses.
        bound: The most that may be left [1].
        most: The most impulses that it may have, two at least: more are taken out even where
            that leaves more than the bound.

    Returns:
        The design with fewer impulses, or as it is.
    """
    best = design
    while best.shaper.times.size > _LEAST:
        fewer = _one_fewer(criterion, best.shaper)
        residual = float(criterion(fewer))
        if residual > bound and best.shaper.times.size <= most:
            break
        best = Design(fewer, residual, design.lower_bound)
    return best


def _one_fewer(criterion: Criterion, shaper: Shaper) -> Shaper:
    """The best shaper that was found with one impulse fewer."""
    starts = sorted(_without_one(shaper), key=lambda each: float(criterion(each)))
    if shaper.times.size - 1 > IMPULSES:
        return starts[0]
    moved = [refined(criterion, start) for start in starts[:_REFINED]]
    return min(moved, key=lambda each: float(criterion(each)))


def _without_one(shaper: Shaper) -> Iterator[Shaper]:
    """Shapers without an inner impulse, and with two neighbours in one place."""
    times, amplitudes = np.asarray(shaper.times), np.asarray(shaper.amplitudes)
    count = times.size
    for number in range(1, count - 1):
        yield _shaper(np.delete(times, number), np.delete(amplitudes, number))
    for first, second in itertools.pairwise(range(count)):
        total = amplitudes[first] + amplitudes[second]
        share = amplitudes[second] / total if total > 0 else 0.5
        places = [times[first] + share * (times[second] - times[first])]
        # An end may stay where it is, so that the duration does, or make the shaper shorter.
        places += [times[0]] if first == 0 else []
        places += [times[-1]] if second == count - 1 else []
        for place in places:
            at, merged = np.delete(times, second), np.delete(amplitudes, second)
            at[first], merged[first] = place, total
            yield _shaper(at, merged)


def _shaper(
    times: Float[np.ndarray, " impulses"], sizes: Float[np.ndarray, " impulses"]
) -> Shaper:
    return Shaper(times - times[0], sizes / sizes.sum())
