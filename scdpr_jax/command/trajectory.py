"""Reference trajectories of the end-effector: Bézier legs and the manoeuvres of Table 3."""

import abc
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import concrete, real, refuse, si

QUARTIC: tuple[float, ...] = (0.0, 0.0, 0.5, 1.0, 1.0)
"""Section 6.2's 4th-order Bézier from rest to rest: $3s^2 - 2s^3$.

The end points and rest at both ends fix four of five control points; the middle one is
that of the symmetric profile, which the campaigns' rigs follow to the last printed digit.
The acceleration jumps at both ends.
"""

MINIMUM_JERK: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
"""The quintic $10s^3 - 15s^4 + 6s^5$, whose acceleration starts and ends at zero."""


class Trajectory(eqx.Module):
    """A reference position over time, at rest before 0 and after its duration."""

    duration: eqx.AbstractVar[Float[Array, "..."]]
    """Time from 0 to the rest at the last position [s]."""

    @abc.abstractmethod
    def position(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        """Commanded position of the end-effector.

        Args:
            time: Any time [s]; the first position before 0, the last after the duration.

        Returns:
            Position $[x_e, y_e]$ [m].
        """

    def velocity(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        """Commanded velocity, the derivative of the position.

        Args:
            time: Any time [s].

        Returns:
            Velocity [m/s].
        """
        return jax.jvp(self.position, (time,), (jnp.ones_like(time),))[1]

    def acceleration(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        """Commanded acceleration; where it jumps, the moving side's.

        Args:
            time: Any time [s].

        Returns:
            Acceleration [m/s²].
        """
        return jax.jvp(self.velocity, (time,), (jnp.ones_like(time),))[1]


def _positive_duration(value: Any) -> Float[Array, "..."]:
    duration = real(value)
    message = (
        "`duration` of a leg must be positive [s], got one that isn't: "
        "give the time that the leg takes."
    )
    return refuse(duration, ~(concrete(duration) > 0), message)


class BezierLeg(Trajectory):
    r"""One Bézier curve, run through at an even pace of its parameter.

    $$ p(t) = \sum_{i=0}^n \binom{n}{i} s^i (1 - s)^{n-i} P_i, \qquad s = t / t_s $$
    """

    control_points: Float[Array, "... points 2"] = eqx.field(
        converter=real, metadata=si("m", "P_i")
    )
    """Control points $P_0 \\dots P_n$ [m]; their number is the order plus one."""
    duration: Float[Array, "..."] = eqx.field(
        converter=_positive_duration, metadata=si("s", "t_s")
    )
    """Time $t_s$ from the first to the last control point [s]."""

    def position(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        # Both ends count as inside, so that derivatives there are the leg's; and so does all
        # time if the duration is no number, so that neither is the place.
        inside = ~((time < 0) | (time > self.duration))
        outside = jnp.where(time > 0, jnp.ones_like(time), jnp.zeros_like(time))
        parameter = jnp.where(inside, time / self.duration, outside)
        points = self.control_points
        # De Casteljau's scheme: exact at both ends, no powers to cancel.
        for _ in range(points.shape[0] - 1):
            points = (1 - parameter) * points[:-1] + parameter * points[1:]
        return points[0]


def rest_to_rest(
    start: Any, end: Any, *, duration: Any, profile: tuple[float, ...] = QUARTIC
) -> BezierLeg:
    r"""A straight leg that starts and ends at rest.

    $$ P_i = p_0 + c_i (p_1 - p_0) $$

    Args:
        start: First position $p_0$, array-like of shape (2,) [m].
        end: Last position $p_1$, array-like of shape (2,) [m].
        duration: Time of the leg [s].
        profile: Share $c_i$ of the way at each control point [1], from 0 to 1.

    Returns:
        The leg.

    Raises:
        ValueError: If the profile doesn't lead from 0 to 1, or not from rest to rest.
    """
    if len(profile) < 4 or profile[:2] != (0.0, 0.0) or profile[-2:] != (1.0, 1.0):
        raise ValueError(
            f"`profile` must start with 0, 0 and end with 1, 1 [1], got {profile}: a leg that "
            "moves at its ends needs its own `BezierLeg(control_points, duration)`."
        )
    start, end = real(start), real(end)
    return BezierLeg(jnp.stack([start + c * (end - start) for c in profile]), duration)


def _joined(legs: tuple[Trajectory, ...]) -> tuple[Trajectory, ...]:
    if not legs:
        raise ValueError("`legs` of a manoeuvre must hold at least one leg, got none: add one.")
    for index in range(1, len(legs)):
        end = legs[index - 1].position(legs[index - 1].duration)
        start = legs[index].position(jnp.zeros_like(legs[index].duration))
        # Control points computed in two ways may differ by roundings of their size.
        tolerance = 64 * jnp.finfo(end.dtype).eps * (1 + jnp.max(jnp.abs(end)))
        message = (
            f"leg {index + 1} of a manoeuvre must start where leg {index} ends [m], got a "
            "jump: give both the same position."
        )
        legs = refuse(legs, ~(jnp.max(jnp.abs(start - end)) <= tolerance), message)
    return legs


class Manoeuvre(Trajectory):
    """Legs one after the other, from a start time on; the last position is held."""

    legs: tuple[Trajectory, ...] = eqx.field(converter=_joined)
    """The legs, each starting where the one before ends."""
    start_time: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("s", "t_0")
    )
    """When the first leg starts [s]; the first position is held until then."""

    @property
    def duration(self) -> Float[Array, "..."]:
        return self.start_time + sum(leg.duration for leg in self.legs)

    def position(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        elapsed = time - self.start_time
        position = self.legs[0].position(elapsed)
        for before, leg in zip(self.legs[:-1], self.legs[1:], strict=True):
            elapsed = elapsed - before.duration
            position = jnp.where(elapsed >= 0, leg.position(elapsed), position)
        return position


class Table3(NamedTuple):
    """The three manoeuvres of Table 3."""

    horizontal: Manoeuvre
    """From [0.3, 0.55] m to [1.9, 0.55] m and back."""
    vertical: Manoeuvre
    """From [0.55, 0.20] m to [0.55, 0.9] m and back."""
    diagonal: Manoeuvre
    """From [2.08, 0.92] m to [0.01, 0.19] m and back."""


TABLE_3_LEG_TIMES: tuple[float, float, float] = (4.0, 4.5, 2.5)
"""Table 3's trajectory times [s], each read as the time of one leg: see `docs/errata.md`."""


def table_3(
    *,
    start_time: Any = 0.0,
    leg_times: tuple[Any, Any, Any] = TABLE_3_LEG_TIMES,
    profile: tuple[float, ...] = QUARTIC,
) -> Table3:
    """The controlled manoeuvres of Table 3: out, and back to the initial pose.

    The table doesn't say whether its time is that of one leg or of both. The diagonal
    decides for one leg: at 2.5 s a leg it asks for 10.1 V at mid-leg, "near the saturation
    limit", at 1.25 s for 20 V. The campaigns' rigs nevertheless ran the horizontal and the
    vertical manoeuvre in half of it (`leg_times=(2.0, 2.25, 2.5)`, `start_time=0.2`).

    The diagonal's intermediate pose, x = 0.01 m, is closer to the frame than half a carriage
    and so outside the workspace of Eq. (1).

    Args:
        start_time: When the first leg starts [s].
        leg_times: Time of one leg of the horizontal, vertical and diagonal manoeuvre [s].
        profile: Share of the way at each control point [1], see `rest_to_rest`.

    Returns:
        The horizontal, vertical and diagonal manoeuvre.
    """
    horizontal, vertical, diagonal = leg_times
    return Table3(
        _there_and_back((0.3, 0.55), (1.9, 0.55), horizontal, start_time, profile),
        _there_and_back((0.55, 0.20), (0.55, 0.9), vertical, start_time, profile),
        _there_and_back((2.08, 0.92), (0.01, 0.19), diagonal, start_time, profile),
    )


def _there_and_back(
    initial: tuple[float, float],
    intermediate: tuple[float, float],
    duration: Any,
    start_time: Any,
    profile: tuple[float, ...],
) -> Manoeuvre:
    out = rest_to_rest(initial, intermediate, duration=duration, profile=profile)
    back = rest_to_rest(intermediate, initial, duration=duration, profile=profile)
    return Manoeuvre((out, back), start_time)
