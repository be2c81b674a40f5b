"""What the shapers of the catalogue share: a mode's period, its decay, and its scale."""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.fields import concrete, real, refuse


def damped_period(frequency: Any, damping_ratio: Any) -> Float[Array, ""]:
    r"""Period of the free vibration, $T_d = 1 / (f \sqrt{1 - \zeta^2})$.

    Args:
        frequency: Undamped natural frequency $f$ [Hz].
        damping_ratio: Damping ratio $\zeta$ [1], below 1.

    Returns:
        Damped period [s].
    """
    return 1 / (real(frequency) * jnp.sqrt(1 - jnp.square(real(damping_ratio))))


@jax.jit
def half_period_decay(damping_ratio: Any) -> Float[Array, ""]:
    r"""What half a period leaves of an amplitude, $K = e^{-\pi\zeta / \sqrt{1 - \zeta^2}}$.

    Args:
        damping_ratio: Damping ratio $\zeta$ [1], below 1.

    Returns:
        Decay [1].
    """
    ratio = real(damping_ratio)
    return jnp.exp(-jnp.pi * ratio / jnp.sqrt(1 - jnp.square(ratio)))


def shaper_of_mode(
    frequency: Any,
    damping_ratio: Any,
    *,
    periods: Float[Array, " impulses"],
    amplitudes: Float[Array, " impulses"],
) -> Shaper:
    """A shaper whose impulses are given in damped periods of a mode.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.
        periods: Instants of the impulses, in damped periods [1].
        amplitudes: Their amplitudes [1].

    Returns:
        The shaper.

    Raises:
        ValueError: If the mode doesn't vibrate.
    """
    frequency, ratio = real(frequency), real(damping_ratio)
    hertz, damping = concrete(frequency), concrete(ratio)
    refused = ~((hertz > 0) & (damping >= 0) & (damping < 1))
    message = (
        "`frequency` [Hz] of a shaper must be positive and its `damping_ratio` [1] within "
        "[0, 1), got one that isn't: a mode that doesn't vibrate needs no shaper."
    )
    frequency = refuse(frequency, refused, message)
    return Shaper(damped_period(frequency, ratio) * periods, amplitudes)
