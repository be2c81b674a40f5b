r"""A leg from rest to rest: a plain profile and what a plan adds to it.

$$ q_3(t) = p_3(t) + \sum_j c_j B_j(t), \qquad y(t) = p_y(t), \qquad
   p(t) = p_0 + f(t / t_s)\,(p_1 - p_0) $$

with the paper's $f(s) = 3 s^2 - 2 s^3$ or one of an evener pace. The $B_j$ are B-splines of
fourth degree whose value and slope vanish at both ends, so that whatever $c$ is, the leg begins
and ends where it should, at rest. Sines, or splines without clamped ends, would do for the way
between; what decides a leg are its last tenths of a second, where splines are local.

Reference: C. de Boor, "On calculating with B-splines", J. Approx. Theory 6(1), 1972,
doi:10.1016/0021-9045(72)90080-9.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax import native

DEGREE = 4
"""Degree of the splines."""
ACTIVE = DEGREE + 1
"""Splines that are not zero at an instant."""
_AT_ENDS = 2
"""Splines left out at either end: those with a value or a slope there."""


class Moment(NamedTuple):
    """Something that moves, at an instant."""

    value: Float[Array | np.ndarray, "..."]
    """Its value."""
    slope: Float[Array | np.ndarray, "..."]
    """Its first derivative [1/s]."""
    curvature: Float[Array | np.ndarray, "..."]
    """Its second derivative [1/s²]."""


def pace(time: Array, duration: Array, order: Array) -> Moment:
    r"""Share of the way by a profile from rest to rest with a plateau of its speed.

    $$ f'(s) = \frac{n + 1}{n - 1} \left(1 - s^n - (1 - s)^n\right), \qquad s = t / t_s $$

    The paper's own is that of order 2, whose largest speed is 1.5 times the mean; that of order
    8 has 1.28, and five thirds of the acceleration at the ends.

    Args:
        time: Time since the begin [s].
        duration: Time $t_s$ that it takes [s].
        order: The order $n$, 2 or more [1].

    Returns:
        The share; 0 before the begin and 1 from the end on, at rest.
    """
    s = jnp.clip(time / duration, 0.0, 1.0)
    moves = jnp.where((time >= 0) & (time < duration), 1.0, 0.0)
    peak = (order + 1) / (order - 1)
    rising, falling = jnp.power(s, order), jnp.power(1 - s, order)
    # The integral and the derivative of the speed, without another power.
    way = s + (falling * (1 - s) - rising * s - 1) / (order + 1)
    bend = jnp.power(1 - s, order - 1) - jnp.power(s, order - 1)
    return Moment(
        peak * way,
        moves * peak * (1 - rising - falling) / duration,
        moves * peak * order * bend / jnp.square(duration),
    )


class Course(NamedTuple):
    """What a leg's plain profile hangs on."""

    begin: Float[Array | np.ndarray, "2"]
    """Where lower carriage and height begin, $[q_3, y_e]$ [m]."""
    end: Float[Array | np.ndarray, "2"]
    """Where they are to end [m]."""
    durations: Float[Array | np.ndarray, "2"]
    """The times that they take [s]: the height has nothing to wait for."""
    order: Float[Array | np.ndarray, ""]
    """Order of the `pace` [1]."""


def plain_profile(course: Course, time: Array) -> Moment:
    """The plain profile of lower carriage and height.

    Args:
        course: What it hangs on.
        time: Time since the begin [s].

    Returns:
        Positions, velocities and accelerations of $[q_3, y_e]$ [m; m/s; m/s²].
    """
    shares = pace(time, course.durations, course.order)
    way = course.end - course.begin
    return Moment(course.begin + way * shares.value, way * shares.slope, way * shares.curvature)


def splines(time: Array, duration: Array, count: Array) -> tuple[Array, Moment]:
    r"""The splines that are not zero at an instant, by de Boor's recursion.

    $$ B_{j,p} = \frac{t - u_j}{u_{j+p} - u_j} B_{j,p-1}
       + \frac{u_{j+p+1} - t}{u_{j+p+1} - u_{j+1}} B_{j+1,p-1} $$

    Knots are even and clamped, $u_j = t_s \min(\max(j, 0), n) / n$, so that they need no table.

    Args:
        time: Time since the begin [s].
        duration: Time $t_s$ of the deviation [s].
        count: Number $n$ of the splines [1].

    Returns:
        Number of the first one, which may be negative, as the last one's may be $n$ or more:
        those are left out; and the values of all `ACTIVE` ones, zero outside of the time.
    """
    interval = jnp.clip(jnp.floor(time / duration * count), 0.0, count - 1)
    inside = jnp.where((time >= 0) & (time < duration), 1.0, 0.0)

    def knot(number: int) -> Array:
        return duration * jnp.clip(interval + number, 0.0, count) / count

    levels = [[inside]]
    for degree in range(1, DEGREE + 1):
        below, level = levels[-1], [jnp.zeros_like(time)] * (degree + 1)
        for j, value in enumerate(below):
            left, right = knot(j + 1 - degree), knot(j + 1)
            share = value / (right - left)
            level[j] = level[j] + (right - time) * share
            level[j + 1] = level[j + 1] + (time - left) * share
        levels.append(level)
    slopes = _differences(levels[DEGREE - 1], knot, DEGREE)
    curvatures = _differences(_differences(levels[DEGREE - 2], knot, DEGREE - 1), knot, DEGREE)
    stacked = (jnp.stack(own) for own in (levels[DEGREE], slopes, curvatures))
    return interval - _AT_ENDS, Moment(*stacked)


def _differences(below: list[Array], knot: object, degree: int) -> list[Array]:
    """Derivatives of splines of a degree from those of the degree below."""
    made = [jnp.zeros_like(below[0])] * (degree + 1)
    for j, value in enumerate(below):
        share = degree * value / (knot(j + 1) - knot(j + 1 - degree))
        made[j], made[j + 1] = made[j] - share, made[j + 1] + share
    return made


def plain_moments(course: Course, time: Float[np.ndarray, " instants"]) -> Moment:
    """`plain_profile` at some instants.

    Args:
        course: What it hangs on.
        time: The instants [s].

    Returns:
        Positions, velocities and accelerations, a row for each instant.
    """
    parameters = Course(*(np.asarray(own, float)[None] for own in course))
    _, rows = native.Runs(_plain_rows, parameters)((), time[None])
    return Moment(*(own[0] for own in rows))


def _plain_rows(course: Course, _: tuple, time: Array) -> tuple[tuple, Moment]:
    return (), plain_profile(course, time)


def pace_values(
    time: Float[np.ndarray, " instants"], *, duration: float, order: float
) -> Float[np.ndarray, " instants"]:
    """`pace` at some instants.

    Args:
        time: The instants [s].
        duration: Time that it takes [s].
        order: Its order [1].

    Returns:
        Shares of the way.
    """
    return plain_moments(
        Course(np.zeros(2), np.ones(2), np.full(2, duration), np.array(order)), time
    ).value[:, 0]


def spline_moments(
    time: Float[np.ndarray, " instants"], *, duration: float, count: int
) -> Float[np.ndarray, "3 instants splines"]:
    """All splines of a leg at some instants.

    Args:
        time: The instants [s].
        duration: Time of the deviation [s].
        count: Number of the splines.

    Returns:
        Values [1] and two derivatives [1/s; 1/s²].
    """
    columns, active = _active(time, duration, count)
    made = np.zeros((3, time.size, count + 2 * _AT_ENDS))
    for whole, own in zip(made, active, strict=True):
        np.put_along_axis(whole, columns, own, axis=1)
    return np.ascontiguousarray(made[..., _AT_ENDS:-_AT_ENDS])


def spline_sums(
    coefficients: Float[np.ndarray, " splines"],
    time: Float[np.ndarray, " instants"],
    *,
    duration: float,
) -> Float[np.ndarray, "3 instants"]:
    """A deviation by splines at some instants, of which few are anywhere.

    Args:
        coefficients: Of all splines of a leg [m].
        time: The instants [s].
        duration: Time of the deviation [s].

    Returns:
        Its values [m] and two derivatives [m/s; m/s²].
    """
    columns, active = _active(time, duration, coefficients.size)
    own = np.pad(coefficients, _AT_ENDS)[columns]
    return np.stack([np.sum(own * part, axis=1) for part in active])


def _active(
    time: Float[np.ndarray, " instants"], duration: float, count: int
) -> tuple[Int[np.ndarray, "instants active"], Moment]:
    """`splines` at some instants, and which of them these are, counted with those left out."""
    about = (np.array([duration]), np.array([float(count)]))
    _, (first, active) = native.Runs(_spline_rows, about)((), time[None])
    columns = first[0].astype(int)[:, None] + (np.arange(ACTIVE) + _AT_ENDS)
    return columns, Moment(*(own[0] for own in active))


def _spline_rows(
    about: tuple[Array, Array], _: tuple, time: Array
) -> tuple[tuple, tuple[Array, Moment]]:
    return (), splines(time, *about)
