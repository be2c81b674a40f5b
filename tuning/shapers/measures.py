"""What shapers are compared by besides the vibration that they leave."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper, residual_vibration
from scdpr_jax.robot.fields import real

_POINTS = 4001


def smoothing(shaper: Shaper, *, acceleration: Any) -> Float[Array, ""]:
    r"""How far a shaped move under constant acceleration is from the same move delayed.

    $$ s = \frac{a}{2} \sum_i A_i (t_i - \bar t)^2, \qquad \bar t = \sum_i A_i t_i $$

    The mean of delayed parabolas is the parabola delayed by the mean and lifted by this: a
    corner of the path is rounded by as much.

    Args:
        shaper: The impulses.
        acceleration: Acceleration $a$ of the move [m/s²].

    Returns:
        Distance [m]; negative impulses may make it negative.
    """
    away = shaper.times - shaper.amplitudes @ shaper.times
    return real(acceleration) / 2 * (shaper.amplitudes @ jnp.square(away))


def residual_of_modes(
    shaper: Shaper, frequency: Any, damping_ratio: Any
) -> Float[np.ndarray, " modes"]:
    """Residual vibration of a shaper in each of some modes.

    Args:
        shaper: The impulses.
        frequency: Undamped natural frequencies [Hz].
        damping_ratio: Damping ratios [1].

    Returns:
        Residual vibration [1].
    """
    return np.asarray(_of_modes(shaper, real(frequency), real(damping_ratio)))


@jax.jit
def _of_modes(
    shaper: Shaper, frequency: Float[Array, " modes"], damping_ratio: Float[Array, " modes"]
) -> Float[Array, " modes"]:
    return jax.vmap(
        lambda f, ratio: residual_vibration(shaper, frequency=f, damping_ratio=ratio)
    )(frequency, damping_ratio)


def insensitivity(
    shaper: Shaper, *, frequency: float, damping_ratio: float, tolerance: float = 0.05
) -> float:
    r"""Width of the band around a frequency within which a shaper leaves little.

    Args:
        shaper: The impulses.
        frequency: Nominal frequency $f_n$ [Hz].
        damping_ratio: Damping ratio over the band [1].
        tolerance: What may be left [1]; a hump that reaches it exactly is within.

    Returns:
        $(f_{high} - f_{low}) / f_n$ [1], 0 if it leaves more at the nominal frequency; both
        ends are sought between 0 and 3 times that.
    """
    ratios = np.linspace(0, 3, 3 * _POINTS)
    # A hump touches the tolerance: rounding mustn't end the band there.
    most = tolerance * (1 + 1e-9)
    residual = residual_of_modes(
        shaper, frequency * ratios, np.full_like(ratios, damping_ratio)
    )
    nominal = int(np.argmin(np.abs(ratios - 1)))
    if residual[nominal] > most:
        return 0.0
    outside = residual > most
    above = nominal + int(np.argmax(outside[nominal:])) if outside[nominal:].any() else None
    below = nominal - int(np.argmax(outside[nominal::-1]))

    def crossing(inside: int, beyond: int) -> float:
        share = (most - residual[inside]) / (residual[beyond] - residual[inside])
        return float(ratios[inside] + share * (ratios[beyond] - ratios[inside]))

    high = float(ratios[-1]) if above is None else crossing(above - 1, above)
    return high - crossing(below + 1, below)
