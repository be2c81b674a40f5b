r"""Legs that a shaper doesn't make longer.

A shaper of duration $d$ makes a leg end $d$ later. Here the leg itself is run in $t_s - d$
and then shaped, so that it still takes $t_s$ and ends exactly at its pose; legs of a
manoeuvre are shaped one by one, or the turning pose would be cut off.
"""

from typing import Any

import equinox as eqx

from scdpr_jax.fields import real
from scdpr_jax.shaper import ShapedTrajectory, Shaper
from scdpr_jax.trajectory import QUARTIC, Manoeuvre, rest_to_rest


def shaped_leg(
    start: Any,
    end: Any,
    *,
    duration: Any,
    shaper: Shaper,
    profile: tuple[float, ...] = QUARTIC,
) -> ShapedTrajectory:
    """A straight leg from rest to rest that is shaped and still takes its time.

    Args:
        start: First position, array-like of shape (2,) [m].
        end: Last position, array-like of shape (2,) [m].
        duration: Time of the shaped leg [s], more than twice the shaper's.
        shaper: The impulses.
        profile: Share of the way at each control point [1], see `rest_to_rest`.

    Returns:
        The leg, of exactly that duration.
    """
    duration = real(duration)
    message = (
        "`duration` of a shaped leg must be more than twice its shaper's [s], got a shorter "
        "one: give the leg more time, or use a shorter shaper."
    )
    duration = eqx.error_if(duration, ~(duration > 2 * shaper.duration), message)
    leg = rest_to_rest(start, end, duration=duration - shaper.duration, profile=profile)
    return ShapedTrajectory(leg, shaper)


def there_and_back(
    start: Any, end: Any, *, leg_time: Any, shaper: Shaper, start_time: Any = 0.0
) -> Manoeuvre:
    """A shaped leg and a shaped leg back, in the time that they take unshaped.

    Args:
        start: First and last position, array-like of shape (2,) [m].
        end: Position in between, array-like of shape (2,) [m].
        leg_time: Time of each leg [s].
        shaper: The impulses.
        start_time: When the first leg starts [s].

    Returns:
        The manoeuvre.
    """
    out = shaped_leg(start, end, duration=leg_time, shaper=shaper)
    back = shaped_leg(end, start, duration=leg_time, shaper=shaper)
    return Manoeuvre((out, back), start_time)
