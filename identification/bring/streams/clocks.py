"""Clocks of channels, and one channel's values at another's instants.

What is measured goes over linearly between two samples, because a sensor's signal is smooth
between them. A command isn't: an amplifier holds it until the next one comes, so it is held
here, and a stream's own instants are those at which its commands change.
"""

import dataclasses

import numpy as np
from jaxtyping import Float64

SAME = 1e-3
"""Share of a period within which two samples are of one instant [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Clock:
    """Instants of samples."""

    epoch: int | None
    """Whole seconds since 1970 that they count from, None where that isn't known."""
    instants: Float64[np.ndarray, " samples"]
    """Time of each [s]."""

    @property
    def period(self) -> float:
        """Time between two samples [s]."""
        steps = np.diff(self.instants)
        return float(np.median(steps)) if steps.size else 0.0

    def since(self, epoch: int | None) -> "Clock":
        """The same instants, counted from another second.

        Args:
            epoch: Whole seconds since 1970, None to leave them.

        Returns:
            The clock; itself where either doesn't know.
        """
        if epoch is None or self.epoch is None:
            return self
        return Clock(epoch, self.instants + (self.epoch - epoch))


def covered(instants: Float64[np.ndarray, " samples"], clock: Clock) -> tuple[float, float]:
    """From when to when a clock has samples, with what two instants may differ by.

    Args:
        instants: Instants of a stream [s].
        clock: A channel's clock, counted from the same second.

    Returns:
        First and last time [s].
    """
    slack = SAME * max(clock.period, float(np.median(np.diff(instants))))
    return clock.instants[0] - slack, clock.instants[-1] + slack


def carried_over(
    values: Float64[np.ndarray, " samples"],
    clock: Clock,
    instants: Float64[np.ndarray, " _"],
    *,
    held: bool,
) -> tuple[Float64[np.ndarray, " _"], str]:
    """A channel's values at other instants.

    Args:
        values: Its values.
        clock: Its own clock.
        instants: The instants, between its first and its last sample [s].
        held: Whether a value holds until the next sample.

    Returns:
        The values; and how they were made, empty where the instants are its own.
    """
    own = clock.instants
    slack = SAME * clock.period
    after = np.clip(np.searchsorted(own, instants), 1, len(own) - 1)
    near = np.where(instants - own[after - 1] < own[after] - instants, after - 1, after)
    same = np.abs(own[near] - instants) <= slack
    if same.all():
        return values[near], ""
    if held:
        last = np.searchsorted(own, instants + slack, side="right") - 1
        return values[np.maximum(last, 0)], "held from its own clock"
    left, right = values[after - 1], values[after]
    share = (instants - own[after - 1]) / (own[after] - own[after - 1])
    between = left + np.clip(share, 0.0, 1.0) * (right - left)
    return np.where(same, values[near], between), "linear interpolation from its own clock"
