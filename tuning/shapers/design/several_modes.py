"""Shapers for several modes: one after the other, and all at once."""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper, convolve
from tuning.shapers.catalogue import zv
from tuning.shapers.design.criterion import Criterion, phasors, worst_residual
from tuning.shapers.design.positive import least_duration

_NEARLY = 1e-5
"""Residual from which Newton's method goes on to none [1]."""
_STEPS = 8
_LEFT = 1e-12
"""Residual that is called none: rounding over some tens of periods [1]."""


def convolved(
    frequencies: Sequence[float],
    damping_ratios: Sequence[float],
    *,
    design: Callable[[Any, Any], Shaper] = zv,
) -> Shaper:
    """A shaper of the catalogue for each mode, one after the other.

    Simple, and what each does for its mode all of them do; but the durations add up.

    Args:
        frequencies: Undamped natural frequencies of the modes [Hz].
        damping_ratios: Their damping ratios [1].
        design: Which shaper of the catalogue.

    Returns:
        The shaper.

    Reference: N. C. Singer, W. P. Seering, see `tuning.shapers.catalogue.zv`.
    """
    each = [design(f, ratio) for f, ratio in zip(frequencies, damping_ratios, strict=True)]
    return functools.reduce(convolve, each)


def simultaneous(frequencies: Sequence[float], damping_ratios: Sequence[float]) -> Shaper:
    """The shortest shaper of positive impulses that leaves nothing in several modes.

    Shorter than `convolved`, with as many impulses as the conditions of all modes ask for.

    Args:
        frequencies: Undamped natural frequencies of the modes [Hz].
        damping_ratios: Their damping ratios [1].

    Returns:
        The shaper.

    Raises:
        FloatingPointError: If the conditions couldn't be met to rounding.

    Reference: J. M. Hyde, W. P. Seering, "Using input command pre-shaping to suppress
    multiple mode vibration", Proc. IEEE ICRA 1991, doi:10.1109/ROBOT.1991.132020.
    """
    criterion = worst_residual(jnp.asarray(frequencies), jnp.asarray(damping_ratios))
    near = least_duration(
        criterion, bound=_NEARLY, starts=[convolved(frequencies, damping_ratios)]
    ).shaper
    exact = _emptied(criterion, near)
    left = float(criterion(exact))
    if not (left <= _LEFT and float(jnp.min(exact.amplitudes)) > 0):
        raise FloatingPointError(
            f"`frequencies`: the modes {list(frequencies)} leave {left:.2g} [1], expected "
            f"{_LEFT:g}. Modes that are nearly one need one condition: leave one of them out."
        )
    return exact


def _emptied(criterion: Criterion, shaper: Shaper) -> Shaper:
    """The nearest shaper that leaves nothing: Newton's steps of least length."""

    def conditions(x: Float[Array, " unknowns"]) -> Float[Array, " conditions"]:
        amplitudes, later = x[: shaper.times.size], x[shaper.times.size :]
        times = jnp.concatenate([jnp.zeros(1), later]) * shaper.duration
        left = phasors(criterion, times, end=times[-1]) @ amplitudes
        return jnp.append(left.ravel(), jnp.sum(amplitudes) - 1)

    slope = jax.jit(jax.jacfwd(conditions))
    x = jnp.append(shaper.amplitudes, shaper.times[1:] / shaper.duration)
    for _ in range(_STEPS):
        step = np.linalg.lstsq(np.asarray(slope(x)), np.asarray(conditions(x)))[0]
        x = x - step
    amplitudes, later = x[: shaper.times.size], x[shaper.times.size :]
    times = jnp.concatenate([jnp.zeros(1), later]) * shaper.duration
    return Shaper(times, amplitudes)
