"""Positions that jump: counters that wrap, and encoders that lose counts.

A step between two samples is compared with the steps before it and after it. A motion stands
out on one side at most, where the axis starts or stops; a jump stands out on both. Where
samples are missing, the axis moves on for longer: such a step counts by its part in a period.
Jumps of one size that a counter has are its wraps, and are taken out; a jump of another size is
one place where the record can't go on, and is left for it to be divided there.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

LEAST_COUNTS = 12
"""Resolutions that a jump is at least."""

USUAL = 8.0
"""Times what a step usually differs from its neighbours by that a jump is at least [1]."""

ALIKE = 0.05
"""Relative difference up to which jumps are of one size [1]."""

NEAR = 3
"""Steps to either side that a step is compared with."""


class Continued(NamedTuple):
    """Positions without a counter's wraps."""

    position: Float64[np.ndarray, " samples"]
    """Positions that go on."""
    period: float
    """Where the counter wraps; 0 where it doesn't."""
    wraps: int
    """How often it did."""


def continued(
    time: Float64[np.ndarray, " samples"],
    position: Float64[np.ndarray, " samples"],
    *,
    rotary: bool,
) -> Continued:
    """Positions with a counter's wraps taken out.

    Args:
        time: Times of the samples [s].
        position: Positions as they were logged [m or rad].
        rotary: Whether they are angles, which wrap at a turn.

    Returns:
        The positions, and what was done.
    """
    step, periods = np.diff(position), _periods(time)
    rows = np.flatnonzero(jumps(time, position))
    if not rows.size:
        return Continued(position, 0.0, 0)
    turns = {"turn": 2 * math.pi} if rotary else {}
    count = resolution(position)
    counters = turns | {"16": 2**16 * count, "15": 2**15 * count}
    moved = periods * _near(step / periods)
    size = float(np.median(np.abs(step - moved)[rows]))
    wraps_at = [each for each in counters.values() if abs(size / each - 1) < ALIKE]
    if not wraps_at:
        return Continued(position, 0.0, 0)
    period = wraps_at[0]
    counted = np.zeros(len(step))
    counted[rows] = np.round((step - moved)[rows] / period)
    wraps = int(np.count_nonzero(counted))
    return Continued(
        position - np.concatenate([[0.0], np.cumsum(counted)]) * period, period, wraps
    )


def jumps(
    time: Float64[np.ndarray, " samples"], position: Float64[np.ndarray, " samples"]
) -> Bool[np.ndarray, " steps"]:
    """Steps that can't be motion.

    Args:
        time: Times of the samples [s].
        position: Positions [m or rad].

    Returns:
        True for each such step.
    """
    step = np.diff(position) / _periods(time)
    if len(step) < 2 * NEAR + 1 or not np.any(step):
        return np.zeros(len(step), dtype=bool)
    before, after = _sides(step)
    lone = np.minimum(np.abs(step - before), np.abs(step - after))
    usual = float(np.quantile(np.abs(step - _near(step)), 0.93))
    # A slow log may start and stop from one sample to the next. Steps themselves would make a
    # motion of the wraps of an axis that turns once in a hundred samples.
    fastest = float(np.quantile(np.maximum(np.abs(before), np.abs(after)), 0.99))
    return lone > max(USUAL * usual, LEAST_COUNTS * resolution(position), 2 * fastest)


def resolution(position: Float64[np.ndarray, " samples"]) -> float:
    """The least step that positions show.

    Args:
        position: Positions [m or rad].

    Returns:
        It; 0 for positions that stand still.
    """
    step = np.abs(np.diff(position))
    moved = step[step > 1e-9 * np.max(np.abs(position), initial=0.0)]
    return float(np.min(moved)) if moved.size else 0.0


def _periods(time: Float64[np.ndarray, " samples"]) -> Float64[np.ndarray, " steps"]:
    """How many periods each step takes; one where its stamps lie closer, which are late."""
    step = np.diff(time)
    return np.maximum(step / np.median(step), 1.0)


def _sides(
    step: Float64[np.ndarray, " steps"],
) -> tuple[Float64[np.ndarray, " steps"], Float64[np.ndarray, " steps"]]:
    """Medians of the steps before each and of those after it."""
    padded = np.pad(step, NEAR, mode="reflect")
    shifted = [padded[shift : shift + len(step)] for shift in range(2 * NEAR + 1)]
    return np.median(shifted[:NEAR], axis=0), np.median(shifted[NEAR + 1 :], axis=0)


def _near(step: Float64[np.ndarray, " steps"]) -> Float64[np.ndarray, " steps"]:
    before, after = _sides(step)
    return (before + after) / 2
