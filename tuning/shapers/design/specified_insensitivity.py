"""The shortest shaper that keeps a tolerance over a band of frequencies."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.design.criterion import worst_residual
from tuning.shapers.design.positive import least_duration
from tuning.shapers.measures import residual_of_modes

_EVEN, _PEAKS, _FINE, _ROUNDS = 40, 8, 2001, 4
_EXCESS = 1e-3
"""By which share of the tolerance a peak between the design's frequencies may exceed it."""


def specified_insensitivity(
    band: tuple[float, float], damping_ratio: float, *, tolerance: float = 0.05
) -> Shaper:
    r"""The shortest shaper of positive impulses with $V \le V_{tol}$ all over a band.

    Where the extra-insensitive shapers take the band that their number of humps gives, this
    one takes what is asked for.

    Args:
        band: Lowest and highest frequency [Hz].
        damping_ratio: Damping ratio over the band [1].
        tolerance: The most that may be left [1], kept to a thousandth of itself.

    Returns:
        The shaper.

    Raises:
        ValueError: If the band isn't one.

    Reference: W. Singhose, W. Seering, N. Singer, "Input shaping for vibration reduction with
    specified insensitivity to modeling errors", Proc. Japan-USA Symp. on Flexible Automation,
    1996.
    """
    low, high = band
    if not 0 < low < high:
        raise ValueError(
            f"`band` must be a lower and a higher frequency [Hz], got {band}: give the "
            "frequencies between which the mode lies."
        )
    even = np.linspace(low, high, _EVEN)
    peaks = np.full(_PEAKS, high)
    fine = np.linspace(low, high, _FINE)
    for number in range(_ROUNDS):
        frequency = np.append(even, peaks)
        criterion = worst_residual(
            jnp.asarray(frequency), jnp.full(frequency.size, damping_ratio)
        )
        # Kept a little below, so that what is between the frequencies may exceed by it.
        shaper = least_duration(criterion, bound=tolerance * (1 - _EXCESS)).shaper
        left = residual_of_modes(shaper, fine, np.full_like(fine, damping_ratio))
        if left.max() <= tolerance * (1 + _EXCESS) or number == _ROUNDS - 1:
            break
        peaks = _highest(fine, left)
    return shaper


def _highest(
    frequency: Float[np.ndarray, " fine"], left: Float[np.ndarray, " fine"]
) -> Float[np.ndarray, " peaks"]:
    """Where the curve has its highest peaks."""
    inner = np.flatnonzero((left[1:-1] >= left[:-2]) & (left[1:-1] >= left[2:])) + 1
    places = inner[np.argsort(-left[inner])][:_PEAKS]
    return np.resize(frequency[places] if places.size else frequency[-1:], _PEAKS)
