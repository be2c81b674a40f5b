"""The catalogue of input shapers with closed forms."""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.fields import real
from scdpr_jax.shaper import Shaper


def damped_period(frequency: Any, damping_ratio: Any) -> Float[Array, ""]:
    r"""Period of the free vibration, $T_d = 1 / (f \sqrt{1 - \zeta^2})$.

    Args:
        frequency: Undamped natural frequency $f$ [Hz].
        damping_ratio: Damping ratio $\zeta$ [1], below 1.

    Returns:
        Damped period [s].
    """
    return 1 / (real(frequency) * jnp.sqrt(1 - jnp.square(real(damping_ratio))))


def half_period_decay(damping_ratio: Any) -> Float[Array, ""]:
    r"""What half a period leaves of an amplitude, $K = e^{-\pi\zeta / \sqrt{1 - \zeta^2}}$.

    Args:
        damping_ratio: Damping ratio $\zeta$ [1], below 1.

    Returns:
        Decay [1].
    """
    ratio = real(damping_ratio)
    return jnp.exp(-jnp.pi * ratio / jnp.sqrt(1 - jnp.square(ratio)))


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
    decay = half_period_decay(damping_ratio)
    amplitudes = jnp.stack([jnp.ones_like(decay), decay]) / (1 + decay)
    return _half_period_steps(frequency, damping_ratio, amplitudes)


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
    decay = half_period_decay(damping_ratio)
    amplitudes = jnp.stack([jnp.ones_like(decay), 2 * decay, jnp.square(decay)])
    return _half_period_steps(frequency, damping_ratio, amplitudes / jnp.square(1 + decay))


def ei(frequency: Any, damping_ratio: Any, *, tolerance: Any = 0.05) -> Shaper:
    r"""Extra insensitive: three impulses, a tolerated share left at the nominal frequency.

    $$ A = \frac{1}{(1 + K)^2} \left[1 + \frac{V}{K},\; 2K - \frac{V}{K} (1 + K^2),\;
       K^2 + K V\right], \qquad t = [0, T_d / 2, T_d] $$

    Without damping these are the amplitudes $[1 + V, 2 - 2V, 1 + V] / 4$ of the reference.
    With damping they solve its conditions for impulses half a damped period apart: the sum
    is 1, the residual vibration at the nominal frequency is V exactly, and the shaper's two
    zeros lie on either side of the mode at equal decay. The hump between the zeros exceeds
    V by 0.1 % of V at the damping ratio 0.1 and by 2 % at 0.3, for V = 0.05 and less.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.
        tolerance: Residual vibration $V$ at the nominal frequency [1].

    Returns:
        A shaper of one damped period.

    Reference: W. Singhose, W. Seering, N. Singer, "Residual vibration reduction using vector
    diagrams to generate shaped inputs", ASME J. Mech. Des. 116(2), 1994,
    doi:10.1115/1.2919428.
    """
    decay, residual = half_period_decay(damping_ratio), real(tolerance)
    first = 1 + residual / decay
    second = 2 * decay - residual / decay * (1 + jnp.square(decay))
    third = jnp.square(decay) + decay * residual
    amplitudes = jnp.stack([first, second, third]) / jnp.square(1 + decay)
    return _half_period_steps(frequency, damping_ratio, amplitudes)


def _half_period_steps(
    frequency: Any, damping_ratio: Any, amplitudes: Float[Array, " impulses"]
) -> Shaper:
    frequency, ratio = real(frequency), real(damping_ratio)
    refused = ~((frequency > 0) & (ratio >= 0) & (ratio < 1))
    message = (
        "`frequency` [Hz] of a shaper must be positive and its `damping_ratio` [1] within "
        "[0, 1), got one that isn't: a mode that doesn't vibrate needs no shaper."
    )
    frequency = eqx.error_if(frequency, refused, message)
    steps = jnp.arange(amplitudes.size, dtype=amplitudes.dtype)
    return Shaper(damped_period(frequency, ratio) / 2 * steps, amplitudes)


class Entry(NamedTuple):
    """A shaper of the catalogue."""

    name: str
    """Name in `shaper.json` and on the command line."""
    design: Callable[[Any, Any], Shaper]
    """From frequency [Hz] and damping ratio [1] to the shaper."""
    periods: float
    """Duration from the first to the last impulse, in damped periods."""
    meaning: str
    """What it does, for a table."""


CATALOGUE: tuple[Entry, ...] = (
    Entry("zv", zv, 0.5, "zero vibration at the nominal frequency"),
    Entry("zvd", zvd, 1.0, "zero vibration, flat around the nominal frequency"),
    Entry("ei", ei, 1.0, "5 % at the nominal frequency, zero on both sides"),
)
"""Every shaper with a closed form, the shortest first."""
