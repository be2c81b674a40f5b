"""The best shaper where a share of the modes may be left worse."""

from typing import Any

import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import real
from tuning.shapers.design.criterion import Criterion, worst_residual
from tuning.shapers.design.positive import Design, least_residual
from tuning.shapers.measures import residual_of_modes

_ROUNDS = 6


def least_quantile(
    frequency: Any,
    damping_ratio: Any,
    *,
    share: float,
    duration: float,
) -> Design:
    """The shaper of a duration whose residual vibration is low in a share of the modes.

    For samples of a posterior: the quantile of the residual instead of its maximum. Leaving
    modes out isn't convex. From the worst case over all, the modes that are left the most are
    given up and the worst case over the others is designed anew, as long as the quantile
    falls: it never rises.

    Args:
        frequency: Undamped natural frequencies of the samples [Hz].
        damping_ratio: Their damping ratios [1].
        share: Share of the samples to count [1], above 0.
        duration: Longest time from the first to the last impulse [s].

    Returns:
        The design; its residual is the quantile, its lower bound that of its own samples.
    """
    frequency, damping_ratio = real(frequency), real(damping_ratio)
    counted = max(1, int(np.ceil(share * frequency.size)))
    best = least_residual(worst_residual(frequency, damping_ratio), duration=duration)
    best = best._replace(residual=_quantile(best, frequency, damping_ratio, counted))
    for _ in range(_ROUNDS):
        residual = residual_of_modes(best.shaper, frequency, damping_ratio)
        kept = np.sort(np.argsort(residual, kind="stable")[:counted])
        chosen: Criterion = worst_residual(frequency[kept], damping_ratio[kept])
        trial = least_residual(chosen, duration=duration, starts=[best.shaper])
        trial = trial._replace(residual=_quantile(trial, frequency, damping_ratio, counted))
        if not trial.residual < best.residual * (1 - 1e-6):
            break
        best = trial
    return best


def _quantile(
    design: Design,
    frequency: Float[Array, " modes"],
    damping_ratio: Float[Array, " modes"],
    counted: int,
) -> float:
    residual = residual_of_modes(design.shaper, frequency, damping_ratio)
    return float(np.sort(residual)[counted - 1])
