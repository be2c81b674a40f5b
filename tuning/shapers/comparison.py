"""The catalogue's shapers at the frequency where each does best by a criterion."""

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.catalogue import Entry
from tuning.shapers.design.criterion import Criterion
from tuning.shapers.measures import smoothing

_POINTS = 500
_ROOM = 8
FREE = 5e-4
"""What a higher frequency, so a shorter shaper, may leave more than the best one [1]."""
WORTH = 0.015
"""Vibration below which a shorter shaper counts for more than a better one [1]."""


class Fitted(NamedTuple):
    """A shaper of the catalogue at the frequency where it does best."""

    entry: Entry
    """Which it is."""
    frequency: float
    """The frequency that it is designed for [Hz]."""
    shaper: Shaper
    """The impulses."""
    residual: float
    """What it leaves by the criterion [1]."""


def fitted(entry: Entry, criterion: Criterion, *, damping_ratio: float) -> Fitted:
    """A shaper of the catalogue at its best frequency.

    Of all frequencies at which it leaves hardly more than the least, `FREE`, the highest:
    it makes the shortest shaper.

    Args:
        entry: The shaper.
        criterion: What is to be least.
        damping_ratio: Damping ratio that it is designed for [1].

    Returns:
        The shaper, its frequency and what it leaves.
    """
    unit = jax.jit(entry.design)(1.0, damping_ratio)
    modes, weights = np.asarray(criterion.frequency), np.asarray(criterion.weights).sum(axis=0)
    # Far below the mean the shaper is long and its higher zeros do the work: no use.
    wide = np.geomspace(modes @ weights / weights.sum() / 3, 3 * modes.max(), _POINTS)
    best = _shortest(unit, criterion, wide)
    ratio = wide[1] / wide[0]
    best = _shortest(unit, criterion, np.geomspace(best / ratio, best * ratio, _POINTS))
    shaper = Shaper(unit.times / best, unit.amplitudes)
    return Fitted(entry, best, shaper, float(criterion(shaper)))


def _shortest(
    unit: Shaper, criterion: Criterion, frequency: Float[np.ndarray, " points"]
) -> float:
    idle = (0, _ROOM - unit.times.size)
    # Idle impulses stand with the last one, which the vibration is measured at.
    times = jnp.pad(unit.times, idle, mode="edge")
    residual = np.asarray(
        _scaled(criterion, times, jnp.pad(unit.amplitudes, idle), jnp.asarray(frequency))
    )
    return float(frequency[np.flatnonzero(residual <= residual.min() + FREE)[-1]])


@jax.jit
def _scaled(
    criterion: Criterion,
    times: Float[Array, " impulses"],
    amplitudes: Float[Array, " impulses"],
    frequency: Float[Array, " points"],
) -> Float[Array, " points"]:
    """What a shaper for 1 Hz leaves, made for other frequencies."""
    return jax.lax.map(
        lambda f: criterion(Shaper(times / f, amplitudes)), frequency, batch_size=64
    )


def pick(candidates: list[Fitted]) -> Fitted:
    r"""The shaper to take from the catalogue: the least $\sqrt{s (V^2 + V_0^2)}$.

    s is the smoothing, so its root is a time, and $V_0$ = `WORTH`: vibration counts until
    little is left, then shortness does. Two impulses tolerate hardly any error of the
    frequency and aren't taken.

    Args:
        candidates: The catalogue's shapers, fitted.

    Returns:
        One of them.
    """

    def price(fit: Fitted) -> float:
        spread = float(smoothing(fit.shaper, acceleration=1.0))
        return math.sqrt(spread * (fit.residual**2 + WORTH**2))

    return min((fit for fit in candidates if fit.shaper.times.size > 2), key=price)
