"""Extra-insensitive shapers: zeros around the nominal mode, humps of one height between."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.command.shaper import Shaper, impulse_phasors
from scdpr_jax.robot.fields import real, refuse
from tuning.shapers.catalogue.periods import shaper_of_mode
from tuning.shapers.newton import continued_root

_REACHED = 1e-11
"""Largest residual of the conditions, scaled to one: rounding, and far below any use."""


def ei(frequency: Any, damping_ratio: Any, *, tolerance: Any = 0.05) -> Shaper:
    r"""Extra insensitive: three impulses, a tolerated share left at the nominal frequency.

    See `extra_insensitive`. Without damping $A = [1 + V, 2 - 2V, 1 + V] / 4$.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.
        tolerance: Residual vibration $V$ at the nominal frequency [1].

    Returns:
        A shaper of one damped period, with damping a little more.

    Reference: W. Singhose, W. Seering, N. Singer, "Residual vibration reduction using vector
    diagrams to generate shaped inputs", ASME J. Mech. Des. 116(2), 1994,
    doi:10.1115/1.2919428.
    """
    return extra_insensitive(frequency, damping_ratio, tolerance=tolerance, humps=1)


def two_hump_ei(frequency: Any, damping_ratio: Any, *, tolerance: Any = 0.05) -> Shaper:
    """Two-hump extra insensitive: nothing left at the nominal frequency, humps beside it.

    See `extra_insensitive`.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.
        tolerance: Residual vibration at the humps [1].

    Returns:
        A shaper of about one and a half damped periods.

    Reference: W. Singhose, L. Porter, T. Tuttle, N. Singer, "Vibration reduction using
    multi-hump input shapers", ASME J. Dyn. Syst. Meas. Control 119(2), 1997,
    doi:10.1115/1.2801257.
    """
    return extra_insensitive(frequency, damping_ratio, tolerance=tolerance, humps=2)


def three_hump_ei(frequency: Any, damping_ratio: Any, *, tolerance: Any = 0.05) -> Shaper:
    """Three-hump extra insensitive: one hump at the nominal frequency, two beside it.

    See `extra_insensitive`.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1], below 1.
        tolerance: Residual vibration at the humps [1].

    Returns:
        A shaper of about two damped periods.

    Reference: Singhose, Porter, Tuttle and Singer, see `two_hump_ei`.
    """
    return extra_insensitive(frequency, damping_ratio, tolerance=tolerance, humps=3)


def extra_insensitive(
    frequency: Any, damping_ratio: Any, *, tolerance: Any, humps: int
) -> Shaper:
    r"""The positive shaper of some humps of one height between zeros, solved exactly.

    n = humps + 2 impulses. Over the frequency, at the damping ratio $\zeta$, the residual
    vibration V has n - 1 zeros and between them n - 2 maxima (humps) of height
    `tolerance`; the middle one of them all is at the nominal frequency:

    $$ \sum_i A_i = 1, \qquad C(f_z) = S(f_z) = 0, \qquad V(f_h) = V_{tol}, \qquad
       V'(f_h) = 0 $$

    These are as many equations as there are amplitudes, times, zeros and humps. Without
    damping the impulses are half a period apart and the amplitudes those of a
    Dolph-Chebyshev array, in closed form; from them, each grown by its decay, Newton's
    method finds the damped ones.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1]; at 5 % two humps exist up to 0.33, three to 0.23.
        tolerance: Residual vibration at the humps [1].
        humps: Their number, at least 1.

    Returns:
        A shaper of about (humps + 1) / 2 damped periods.

    Raises:
        ValueError: If the mode doesn't vibrate or the conditions can't be met.

    References: see `ei` and `two_hump_ei`; C. L. Dolph, "A current distribution for
    broadside arrays", Proc. IRE 34(6), 1946, doi:10.1109/JRPROC.1946.225956.
    """
    ratio, height = jnp.asarray(real(damping_ratio)), real(tolerance)
    periods, amplitudes, missed = _unit_impulses(ratio, height, humps=humps)
    message = (
        "An extra-insensitive shaper couldn't be solved for: its `damping_ratio` [1] should be "
        f"at most 0.2 and its `tolerance` [1] within (0, 0.1], got others for {humps} humps. "
        "Take one of fewer humps, or `zvd`."
    )
    # A mode that doesn't vibrate has a message of its own.
    vibrates = (ratio >= 0) & (ratio < 1)
    amplitudes = refuse(amplitudes, missed & vibrates, message)
    return shaper_of_mode(frequency, ratio, periods=periods, amplitudes=amplitudes)


@functools.partial(jax.jit, static_argnames="humps")
def _unit_impulses(
    damping_ratio: Float[Array, ""], tolerance: Float[Array, ""], *, humps: int
) -> tuple[Float[Array, " impulses"], Float[Array, " impulses"], Bool[Array, ""]]:
    """Instants in damped periods, amplitudes, and whether the conditions were missed."""
    impulses = humps + 2
    amplitudes, zeros, hills = _undamped(tolerance, impulses)
    steps = jnp.arange(impulses, dtype=tolerance.dtype)
    # The middle of zeros and humps stays at the nominal frequency: no unknown.
    if humps % 2:
        hills = jnp.delete(hills, humps // 2)
    else:
        zeros = jnp.delete(zeros, impulses // 2 - 1)
    sizes = (impulses, impulses - 1, zeros.size, hills.size)

    def split(x: Float[Array, " n"]) -> tuple[Float[Array, " _"], ...]:
        a, t, z, h = jnp.split(x, [sum(sizes[: n + 1]) for n in range(3)])
        unit = jnp.ones(1, x.dtype)
        at_zeros, at_hills = (z, jnp.append(h, unit)) if humps % 2 else (jnp.append(z, unit), h)
        return a, jnp.concatenate([0 * unit, t]), at_zeros, at_hills

    def equations(x: Float[Array, " n"], ratio: Float[Array, ""]) -> Float[Array, " n"]:
        a, t, z, h = split(x)
        # Frequencies over the nominal one, instants in its damped periods.
        times = t / jnp.sqrt(1 - jnp.square(ratio))

        def parts(f: Float[Array, ""]) -> Float[Array, "2"]:
            phasors = impulse_phasors(times, end=times[-1], frequency=f, damping_ratio=ratio)
            return phasors @ a / tolerance

        def square(f: Float[Array, ""]) -> Float[Array, ""]:
            return jnp.sum(jnp.square(parts(f)))

        heights, slopes = jax.vmap(jax.value_and_grad(square))(h)
        return jnp.concatenate(
            [
                jnp.sum(a, keepdims=True) - 1,
                jax.vmap(parts)(z).ravel(),
                heights - 1,
                slopes,
            ]
        )

    start = jnp.concatenate([amplitudes, steps[1:] / 2, zeros, hills])
    solution = continued_root(equations, start, parameter=damping_ratio)
    missed = jnp.max(jnp.abs(equations(jax.lax.stop_gradient(solution), damping_ratio)))
    a, t, *_ = split(solution)
    return t, a, ~(missed < _REACHED / tolerance)


def _undamped(
    tolerance: Float[Array, ""], impulses: int
) -> tuple[Float[Array, " impulses"], Float[Array, " _"], Float[Array, " _"]]:
    r"""Amplitudes, zeros and humps without damping, the frequencies over the nominal one.

    $$ V(r) = V_{tol} |T_{n-1}(x_0 \cos(\pi r / 2))|, \qquad V_{tol} T_{n-1}(x_0) = 1 $$
    """
    order = impulses - 1
    stretch = jnp.cosh(jnp.arccosh(1 / tolerance) / order)

    def ratios(places: Float[Array, " _"]) -> Float[Array, " _"]:
        return 2 / jnp.pi * jnp.arccos(jnp.cos(jnp.pi * places / order) / stretch)

    zeros = ratios(jnp.arange(order, dtype=tolerance.dtype) + 0.5)
    hills = ratios(jnp.arange(1, order, dtype=tolerance.dtype))
    # The array's polynomial from its zeros, which are conjugate in pairs around half a turn.
    amplitudes = jnp.ones(1, tolerance.dtype)
    for zero in zeros[: order // 2]:
        pair = jnp.stack(
            [jnp.ones_like(zero), -2 * jnp.cos(jnp.pi * zero), jnp.ones_like(zero)]
        )
        amplitudes = jnp.convolve(amplitudes, pair)
    if order % 2:
        amplitudes = jnp.convolve(amplitudes, jnp.ones(2, tolerance.dtype))
    return amplitudes / jnp.sum(amplitudes), zeros, hills
