r"""A leg from rest to rest: a plain profile and what a plan adds to it.

$$ p(t) = p_0 + f(s)\,(p_1 - p_0) + e_x \sum_j c_j B_j(t), \qquad s = t / t_s $$

with the paper's $f(s) = 3 s^2 - 2 s^3$ or one of an evener pace. The $B_j$ are B-splines of
fourth degree whose value and slope vanish at both ends, so that whatever $c$ is, the leg begins
and ends where it should, at rest.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.interpolate import BSpline

from scdpr_jax.command.trajectory import rest_to_rest
from tuning.plan.feedforward import Motion

_DEGREE = 4
_AT_ENDS = 2
"""Splines left out at either end: those with a value or a slope there."""


def pace(order: int) -> tuple[float, ...]:
    r"""A profile from rest to rest with a plateau of its speed, as shares for `rest_to_rest`.

    $$ f'(s) = \frac{n + 1}{n - 1} \left(1 - s^n - (1 - s)^n\right) $$

    The paper's own is that of order 2, whose largest speed is 1.5 times the mean; that of order
    8 has 1.28, and five thirds of the acceleration at the ends.

    Args:
        order: The order $n$, 2 or more.

    Returns:
        Share of the way at each control point of the Bézier curve [1].
    """
    return (0.0, *(k / (order - 1) for k in range(order)), 1.0)


class Basis(NamedTuple):
    """The B-splines of a leg at some instants."""

    value: Float[Array, "instants splines"]
    """Values [1]."""
    slope: Float[Array, "instants splines"]
    """First derivatives [1/s]."""
    curvature: Float[Array, "instants splines"]
    """Second derivatives [1/s²]."""


def spline_basis(
    leg_time: float, time: Float[np.ndarray, " instants"], *, splines: int
) -> Basis:
    """The leg's B-splines; all of them are zero outside of the leg.

    Args:
        leg_time: Time of the leg [s].
        time: Instants from the leg's begin [s].
        splines: Their number.

    Returns:
        Values and derivatives.
    """
    every = splines + 2 * _AT_ENDS
    inner = np.linspace(0.0, leg_time, every - _DEGREE + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.full(_DEGREE, leg_time)])
    curves = BSpline(knots, np.eye(every)[:, _AT_ENDS:-_AT_ENDS], _DEGREE)
    inside = ((time >= 0) & (time < leg_time))[:, None]
    within = np.clip(time, 0.0, leg_time)
    return Basis(
        *(
            jnp.asarray(np.where(inside, curves.derivative(order)(within), 0.0))
            for order in range(3)
        )
    )


def plain_motion(
    start: Float[Array, "2"],
    end: Float[Array, "2"],
    *,
    leg_time: Float[Array, ""],
    time: Float[Array, " instants"],
    order: int = 2,
) -> Motion:
    """A plain profile, held before and after.

    Args:
        start: First position [m].
        end: Last position [m].
        leg_time: Time of the leg [s].
        time: Instants from the leg's begin [s].
        order: Of its `pace`; the paper's has 2.

    Returns:
        The motion at these instants.
    """
    leg = rest_to_rest(start, end, duration=leg_time, profile=pace(order))
    return Motion(
        jax.vmap(leg.position)(time),
        jax.vmap(leg.velocity)(time),
        # At the leg's last instant its acceleration is the moving side's: it has ended.
        jnp.where((time < leg_time)[:, None], jax.vmap(leg.acceleration)(time), 0.0),
    )


def with_deviation(
    plain: Motion, basis: Basis, coefficients: Float[Array, " splines"]
) -> Motion:
    """The profile with the lower carriage led aside by the splines.

    Args:
        plain: The profile.
        basis: The splines at the same instants.
        coefficients: Their coefficients [m].

    Returns:
        The motion.
    """
    return Motion(
        *(
            part.at[:, 0].add(curves @ coefficients)
            for part, curves in zip(
                (plain.position, plain.velocity, plain.acceleration), basis, strict=True
            )
        )
    )
