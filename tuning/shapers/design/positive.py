"""The best shaper of positive impulses, for a duration or for a bound."""

import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.design.criterion import Criterion, phasors
from tuning.shapers.design.minimax import Minimax, Minimum, minimise
from tuning.shapers.design.refine import IMPULSES, refined

GRID = 33
"""Instants at which the convex program may put impulses; a refinement moves them."""
GAP = 1e-8
"""How close to the least residual the convex program comes [1]."""
_LEAST_AMPLITUDE = 1e-3
"""An amplitude of the grid below this is none [1]: a barrier leaves a little everywhere."""
EXACT = 5e-4
"""How exactly a least duration is found, relative to itself [1]."""
NOTHING_LEFT = 1e-7
"""A residual that is called none [1]."""
_ROUNDING = 1e-12
_TRIES = 12


class Design(NamedTuple):
    """A shaper that was designed, and how good any could be."""

    shaper: Shaper
    """The impulses."""
    residual: float
    """What it leaves by its criterion [1]."""
    lower_bound: float
    """What no shaper of positive impulses on the program's instants leaves less than [1]."""


def least_residual(
    criterion: Criterion, *, duration: float, starts: Iterable[Shaper] = ()
) -> Design:
    r"""The shaper of a duration that leaves least.

    At given instants the amplitudes are a convex program, whose minimum is the minimum.
    Over `GRID` instants this gives the number of the impulses, about where they stand, and
    a lower bound; `refined` then moves them, by gradient, and the best start with them.

    Args:
        criterion: What is to be least.
        duration: Longest time from the first to the last impulse [s].
        starts: Other shapers, of positive impulses: the design is never worse than one of
            them that is no longer.

    Returns:
        The design, of this duration, or the shortest that leaves nothing.
    """
    on_grid = _on_grid(criterion, jnp.asarray(duration))
    starts = [s for s in starts if float(s.duration) <= duration * (1 + _ROUNDING)]
    if float(on_grid.value) <= GAP:
        # Many shapers leave nothing; the shortest is the one with the fewest impulses.
        shortest = least_duration(
            criterion, bound=NOTHING_LEFT, starts=starts, longest=duration
        )
        return _best(criterion, [shortest.shaper, *starts], 0.0)
    candidates = [*_impulses(np.asarray(on_grid.x), duration), *starts]
    ranked = sorted(candidates, key=lambda shaper: float(criterion(shaper)))
    moved = [refined(criterion, shaper) for shaper in ranked[:2]]
    return _best(criterion, [*moved, ranked[0]], float(on_grid.lower_bound))


def least_duration(
    criterion: Criterion,
    *,
    bound: float,
    starts: Iterable[Shaper] = (),
    longest: float = math.inf,
) -> Design:
    """The shortest shaper that leaves no more than a bound.

    The least residual falls with the duration, so the duration is where it meets the
    bound: sought on the convex program first, then among refined shapers.

    Args:
        criterion: What is bounded.
        bound: The most that it may leave [1].
        starts: Other shapers of positive impulses: the design is never longer than one of
            them that keeps the bound.
        longest: A duration that is known to be enough [s].

    Returns:
        The design.

    Raises:
        ValueError: If even a shaper of many periods leaves more.
    """
    # What leaves a little may leave nothing by the convex program, which stops `GAP` short.
    bound, starts = max(bound, NOTHING_LEFT), list(starts)
    low, residual_low, high = (
        0.0,
        1.0,
        longest if math.isfinite(longest) else _longest(criterion, bound),
    )
    while high - low > 0.02 * high:
        middle = (low + high) / 2
        residual = float(_on_grid(criterion, jnp.asarray(middle)).value)
        if residual <= bound:
            high = middle
        else:
            low, residual_low = middle, residual
    best = _on_the_way(criterion, high, low)
    if not best.residual <= bound:
        best = _stretched(criterion, starts, high, best)
    for _ in range(_TRIES):
        if best.residual <= bound:
            break
        low, residual_low, high = high, best.residual, 1.005 * high
        best = _on_the_way(criterion, high, low)
    if not best.residual <= bound:
        # Many small impulses keep it, and no few of them were found that do.
        best = _on_all_instants(criterion, high)
    # A refined shaper leaves less than the grid's: it may be shorter than the grid allows.
    low = min(low, 0.98 * high)
    while high - low > EXACT * high:
        share = (residual_low - bound) / max(residual_low - best.residual, NOTHING_LEFT)
        middle = low + (high - low) * min(max(share, 0.1), 0.9)
        scale = middle / float(best.shaper.duration)
        trial = refined(criterion, Shaper(scale * best.shaper.times, best.shaper.amplitudes))
        residual = float(criterion(trial))
        if residual <= bound:
            best, high = Design(trial, residual, best.lower_bound), middle
        else:
            low, residual_low = middle, residual
    kept = [shaper for shaper in starts if float(criterion(shaper)) <= bound]
    shaper = min([best.shaper, *kept], key=lambda shaper: float(shaper.duration))
    fewer = _without_small(criterion, shaper)
    shaper = fewer if float(criterion(fewer)) <= bound else shaper
    return _best(criterion, [shaper], best.lower_bound)


def _on_the_way(criterion: Criterion, duration: float, shorter: float) -> Design:
    """The grid's shaper of a duration, refined.

    Where nothing is left the grid's amplitudes are smeared over all that do; those of a
    shorter duration, which leaves something, aren't, and stretched they lead further.
    """
    on_grid, shorter_grid = (_on_grid(criterion, jnp.asarray(d)) for d in (duration, shorter))
    starts = [
        s for on in (on_grid, shorter_grid) for s in _impulses(np.asarray(on.x), duration)
    ]
    return _best(criterion, [refined(criterion, s) for s in starts], float(on_grid.lower_bound))


def _stretched(
    criterion: Criterion, starts: list[Shaper], duration: float, design: Design
) -> Design:
    """The best of a design and of other shapers, brought to its duration and refined.

    Where many shapers leave nothing, the grid's hills may stand for none of the few impulses
    that do; a shaper of the catalogue has the right number of them.
    """
    scaled = [
        Shaper(duration / float(s.duration) * s.times, s.amplitudes)
        for s in starts
        if float(s.duration) > 0
    ]
    ranked = sorted(scaled, key=lambda shaper: float(criterion(shaper)))
    moved = [refined(criterion, shaper) for shaper in ranked[:2]]
    return _best(criterion, [design.shaper, *moved], design.lower_bound)


def _without_small(criterion: Criterion, shaper: Shaper) -> Shaper:
    """A shaper without impulses that hardly count, and refined again."""
    times, amplitudes = np.asarray(shaper.times), np.asarray(shaper.amplitudes)
    counts = (amplitudes > _LEAST_AMPLITUDE) | np.isin(times, (times[0], times[-1]))
    if counts.all():
        return shaper
    sizes = amplitudes[counts]
    return refined(criterion, Shaper(times[counts], sizes / sizes.sum()))


def _on_all_instants(criterion: Criterion, duration: float) -> Design:
    """The grid's shaper as it is, an impulse at every instant."""
    on_grid = _on_grid(criterion, jnp.asarray(duration))
    times = jnp.linspace(0, duration, GRID)
    shaper = Shaper(times, on_grid.x / jnp.sum(on_grid.x))
    return _best(criterion, [shaper], float(on_grid.lower_bound))


def _best(criterion: Criterion, shapers: list[Shaper], lower_bound: float) -> Design:
    """The one that leaves least; of those that leave nothing, the one with fewest impulses."""

    def order(shaper: Shaper) -> tuple[float, int]:
        return max(float(criterion(shaper)), NOTHING_LEFT), shaper.times.size

    best = min(shapers, key=order)
    return Design(best, float(criterion(best)), max(lower_bound, 0.0))


def _longest(criterion: Criterion, bound: float) -> float:
    """A duration that is long enough."""
    duration = 0.5 / float(jnp.min(criterion.frequency))
    for _ in range(8):
        if float(_on_grid(criterion, jnp.asarray(duration)).value) <= bound:
            return duration
        duration *= 2
    raise ValueError(
        f"No shaper of up to {duration / 2:.3g} s leaves {bound:.3g} [1] or less of these "
        "modes: allow more, or spread them less."
    )


@jax.jit
def _on_grid(criterion: Criterion, duration: Float[Array, ""]) -> Minimum:
    """The best amplitudes at equally spaced instants from 0 to the duration."""
    times = duration * jnp.linspace(0, 1, GRID, dtype=duration.dtype)
    modes = criterion.frequency.size
    problem = Minimax(
        offset=jnp.zeros((2, modes), duration.dtype),
        slope=phasors(criterion, times, end=duration),
        tolerated=criterion.tolerated,
        weights=criterion.weights,
        lower=jnp.zeros_like(times),
        # Never reached, as they add up to one.
        upper=jnp.full_like(times, 2),
        balance=jnp.ones_like(times),
    )
    return minimise(problem, jnp.full_like(times, 1 / GRID), jnp.asarray(GAP))


def _impulses(amplitudes: Float[np.ndarray, " grid"], duration: float) -> list[Shaper]:
    """What the grid's amplitudes stand for, the fewer impulses first.

    An impulse between two instants is shared by them, so each hill of amplitudes may be one
    impulse at its centre; or there are two, close to each other.
    """
    used = np.where(amplitudes > _LEAST_AMPLITUDE, amplitudes, 0.0)
    valleys = [0, *_valleys(used), GRID]
    hills = [np.arange(a, b) for a, b in itertools.pairwise(valleys)]
    each = [np.array([n]) for n in np.flatnonzero(used)]
    groups = [[hill for hill in hills if used[hill].sum() > 0]]
    if len(each) <= IMPULSES:
        groups.append(each)
    return [_centred(used, group, duration) for group in groups]


def _centred(
    used: Float[np.ndarray, " grid"], hills: list[np.ndarray], duration: float
) -> Shaper:
    """An impulse at each hill's centre; those of the first and last instant stay there."""
    instants = np.linspace(0, duration, GRID)
    sums = np.array([used[hill].sum() for hill in hills])
    times = np.array([used[hill] @ instants[hill] / used[hill].sum() for hill in hills])
    if used[0] > 0:
        times[0] = 0.0
    if used[-1] > 0:
        times[-1] = duration
    return Shaper(times - times[0], sums / sums.sum())


def _valleys(used: Float[np.ndarray, " grid"]) -> list[int]:
    """Where an amplitude is smaller than before and no larger than after."""
    return [n for n in range(1, GRID - 1) if used[n - 1] > used[n] <= used[n + 1]]
