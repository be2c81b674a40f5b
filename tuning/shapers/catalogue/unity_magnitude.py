"""Unity-magnitude shapers: impulses of 1 and -1 in turn, shorter than positive ones."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from scdpr_jax.command.shaper import Shaper, impulse_phasors
from scdpr_jax.robot.fields import real, refuse
from tuning.shapers.catalogue.periods import shaper_of_mode
from tuning.shapers.newton import continued_root

_REACHED = 1e-10
"""Largest residual of the conditions: rounding, and far below any use."""


def um_zv(frequency: Any, damping_ratio: Any) -> Shaper:
    r"""Unity-magnitude zero vibration: a third of a period, where ZV takes a half.

    $$ A = [1, -1, 1], \qquad C(f_n) = S(f_n) = 0 $$

    Without damping $t = [0, T / 6, T / 3]$; with it the two times solve the two conditions.
    Negative impulses ask the drive for more, and excite modes of higher frequency.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1]; up to 0.4 is tested.

    Returns:
        The shaper.

    Raises:
        ValueError: If the mode doesn't vibrate or the conditions can't be met.

    Reference: W. Singhose, W. Seering, N. Singer, "Design and implementation of time-optimal
    negative input shapers", Proc. ASME Winter Annual Meeting, DSC 55-1, 1994; W. Singhose,
    N. Singer, W. Seering, "Time-optimal negative input shapers", ASME J. Dyn. Syst. Meas.
    Control 119(2), 1997, doi:10.1115/1.2801233.
    """
    ratio = real(damping_ratio)
    periods = _checked(*_zero_vibration(ratio))
    return shaper_of_mode(frequency, ratio, periods=periods, amplitudes=_turns(3, ratio))


def um_ei(frequency: Any, damping_ratio: Any, *, tolerance: Any = 0.05) -> Shaper:
    r"""Unity-magnitude extra insensitive: five impulses in some 0.74 of a period.

    $$ A = [1, -1, 1, -1, 1], \qquad V(f_n) = V_{tol}, \qquad V'(f_n) = 0, \qquad
       C(f_z) = S(f_z) = 0 $$

    at two frequencies $f_z$, one on either side. The four times and they solve the six
    conditions.

    Args:
        frequency: Undamped natural frequency [Hz].
        damping_ratio: Damping ratio [1]; up to 0.3 is tested.
        tolerance: Residual vibration at the nominal frequency [1].

    Returns:
        The shaper.

    Raises:
        ValueError: If the mode doesn't vibrate or the conditions can't be met.

    Reference: see `um_zv`.
    """
    ratio = real(damping_ratio)
    periods = _checked(*_extra_insensitive(ratio, real(tolerance)))
    return shaper_of_mode(frequency, ratio, periods=periods, amplitudes=_turns(5, ratio))


def _turns(impulses: int, like: Float[Array, ""]) -> Float[Array, " impulses"]:
    return 1 - 2 * jnp.mod(jnp.arange(impulses, dtype=like.dtype), 2)


def _parts(
    periods: Float[Array, " later"], f: Float[Array, ""], damping_ratio: Float[Array, ""]
) -> Float[Array, "2"]:
    """Phasor at a frequency over the nominal one; the first impulse is at 0."""
    start = jnp.zeros(1, periods.dtype)
    times = jnp.concatenate([start, periods]) / jnp.sqrt(1 - jnp.square(damping_ratio))
    phasors = impulse_phasors(times, end=times[-1], frequency=f, damping_ratio=damping_ratio)
    return phasors @ _turns(times.size, f)


_Solved = tuple[Float[Array, " impulses"], Bool[Array, ""]]
"""Instants in damped periods, and whether the conditions were missed."""


@jax.jit
def _zero_vibration(damping_ratio: Float[Array, ""]) -> _Solved:
    nominal = jnp.ones_like(damping_ratio)

    def equations(x: Float[Array, "2"], ratio: Float[Array, ""]) -> Float[Array, "2"]:
        return _parts(x, nominal, ratio)

    return _solved(equations, jnp.array([1 / 6, 1 / 3], nominal.dtype), damping_ratio, 3)


@jax.jit
def _extra_insensitive(damping_ratio: Float[Array, ""], tolerance: Float[Array, ""]) -> _Solved:
    nominal = jnp.ones_like(damping_ratio)

    def equations(x: Float[Array, "6"], ratio: Float[Array, ""]) -> Float[Array, "6"]:
        def square(f: Float[Array, ""]) -> Float[Array, ""]:
            return jnp.sum(jnp.square(_parts(x[:4], f, ratio) / tolerance))

        height, slope = jax.value_and_grad(square)(nominal)
        zeros = jax.vmap(lambda f: _parts(x[:4], f, ratio))(x[4:])
        return jnp.concatenate([jnp.stack([height - 1, slope]), zeros.ravel()])

    # Near the root at V = 5 % without damping.
    start = jnp.array([0.094, 0.368, 0.642, 0.736, 0.8, 1.2], nominal.dtype)
    return _solved(equations, start, damping_ratio, 5)


def _solved(
    equations: Callable[[Float[Array, " n"], Float[Array, ""]], Float[Array, " n"]],
    start: Float[Array, " n"],
    damping_ratio: Float[Array, ""],
    impulses: int,
) -> _Solved:
    solution = continued_root(equations, start, parameter=damping_ratio)
    missed = jnp.max(jnp.abs(equations(jax.lax.stop_gradient(solution), damping_ratio)))
    instants = jnp.concatenate([jnp.zeros(1, start.dtype), solution[: impulses - 1]])
    disordered = jnp.any(jnp.diff(instants) <= 0)
    return instants, ~(missed < _REACHED) | disordered


def _checked(periods: Float[Array, " impulses"], missed: Bool[Array, ""]) -> Float[Array, " _"]:
    message = (
        "A unity-magnitude shaper couldn't be solved for: its `damping_ratio` [1] should be "
        "at most 0.3 and its `tolerance` [1] within [0.01, 0.1], got others. Take a positive "
        "shaper."
    )
    return refuse(periods, missed, message)
