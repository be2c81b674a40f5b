"""Shapers that leave nothing at the nominal mode: ZV, ZVD, ZVDD and MZV."""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.fields import real
from tuning.shapers.catalogue.periods import half_period_decay, shaper_of_mode


def zv(frequency: Any, damping_ratio: Any) -> Shaper:
    r"""Zero vibration: two impulses, none left at the nominal frequency.

    $$ A = [1, K] / (1 + K), \qquad t = [0, T_d / 2] $$

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.

    Returns:
        A shaper of half a damped period.

    Reference: N. C. Singer, W. P. Seering, "Preshaping command inputs to reduce system
    vibration", ASME J. Dyn. Syst. Meas. Control 112(1), 1990, doi:10.1115/1.2894142.
    """
    return _half_period_steps(frequency, damping_ratio, binomial=(1.0, 1.0))


def zvd(frequency: Any, damping_ratio: Any) -> Shaper:
    r"""Zero vibration and derivative: three impulses, flat at the nominal frequency.

    $$ A = [1, 2K, K^2] / (1 + K)^2, \qquad t = [0, T_d / 2, T_d] $$

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.

    Returns:
        A shaper of one damped period.

    Reference: Singer and Seering, see `zv`.
    """
    return _half_period_steps(frequency, damping_ratio, binomial=(1.0, 2.0, 1.0))


def zvdd(frequency: Any, damping_ratio: Any) -> Shaper:
    r"""Zero vibration and two derivatives: four impulses.

    $$ A = [1, 3K, 3K^2, K^3] / (1 + K)^3, \qquad t = [0, T_d / 2, T_d, 3T_d / 2] $$

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.

    Returns:
        A shaper of one and a half damped periods.

    Reference: Singer and Seering, see `zv`.
    """
    return _half_period_steps(frequency, damping_ratio, binomial=(1.0, 3.0, 3.0, 1.0))


def mzv(frequency: Any, damping_ratio: Any) -> Shaper:
    r"""Zero vibration by three impulses, 3/8 of a damped period apart.

    Half of ZVD's added time, and between ZV and ZVD in what it tolerates. Three impulses
    whose vectors are 135° apart add up to nothing if the middle one is $\sqrt 2$ times the
    outer ones, each grown by the decay until it:

    $$ A = [1, \sqrt 2 k, k^2] / (1 + \sqrt 2 k + k^2), \qquad k = K^{3/4}, \qquad
       t = [0, 3T_d / 8, 3T_d / 4] $$

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.

    Returns:
        A shaper of three quarters of a damped period.

    Reference: the zero-vibration conditions of Singer and Seering, see `zv`, at that spacing.
    """
    decay = half_period_decay(damping_ratio) ** 0.75
    amplitudes = jnp.stack([jnp.ones_like(decay), jnp.sqrt(2.0) * decay, jnp.square(decay)])
    periods = jnp.array([0.0, 0.375, 0.75], decay.dtype)
    return shaper_of_mode(
        frequency, damping_ratio, periods=periods, amplitudes=amplitudes / jnp.sum(amplitudes)
    )


def _half_period_steps(
    frequency: Any, damping_ratio: Any, *, binomial: tuple[float, ...]
) -> Shaper:
    """ZV convolved with itself: binomial coefficients, each grown by the decay until it."""
    decay = half_period_decay(real(damping_ratio))
    steps: Float[Array, " impulses"] = jnp.arange(len(binomial), dtype=decay.dtype)
    amplitudes = jnp.stack([c * decay**n for n, c in enumerate(binomial)])
    return shaper_of_mode(
        frequency,
        damping_ratio,
        periods=steps / 2,
        amplitudes=amplitudes / (1 + decay) ** (len(binomial) - 1),
    )
