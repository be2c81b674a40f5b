"""The least vibration of the worst models for every move time: the Pareto front of both."""

from collections.abc import Sequence

import numpy as np

from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.codesign.models import Models
from tuning.codesign.search import Designed, co_design
from tuning.loop.admissible import Admissible

_SHORTEST, _LONGEST = 1.2, 2.1
"""Ends of the front over the time in which the drives' top speed would do the longest leg at
the plain profile [1]: half again as fast as its mean it is at its middle."""


def front(
    models: Models,
    within: Admissible,
    *,
    move_times: Sequence[float],
    progress: Progress = SILENT,
) -> tuple[Designed, ...]:
    """A design for each of some move times, the vibration never rising with the time.

    Who has more time may move as fast as with less, and wait: a longer move that turns out
    worse than a shorter one isn't on the front.

    Args:
        models: The models.
        within: Which gains are admissible.
        move_times: Times of the moves, the shaper included [s].
        progress: Told what is being done and which share of it is done.

    Returns:
        A design for each time, the shortest first, without those times in which the drives
        can't keep within their limit, and those that a shorter one beats.

    Raises:
        ValueError: If they can't in any.
    """
    times = sorted(move_times)
    limit = float(np.min(models.ensemble.robot.drive.voltage_limit))
    designs: list[Designed] = []
    count = len(times)
    for number, time in enumerate(times):
        design = co_design(
            models,
            within,
            move_time=time,
            longest=times[-1],
            begin=designs[-1:],
            progress=progress.part(number / count, (number + 1) / count, f"{time:.3g} s"),
        )
        if not design.keeps_voltage(limit):
            continue
        if designs and design.vibration > designs[-1].vibration:
            continue
        designs.append(design)
    if not designs:
        raise ValueError(
            f"`move_times` are too short for the drives, got {times[-1]:.3g} s at the longest "
            f"[s], in which the worst model needs more than {limit:g} V. Give the move more "
            "time, or shorten the legs."
        )
    return tuple(designs)


def knee(designs: Sequence[Designed]) -> Designed:
    """The design that trades move time for vibration best: the least product of both.

    Args:
        designs: A front.

    Returns:
        One of its designs; the product's place doesn't depend on either unit.
    """
    return min(designs, key=lambda design: design.move_time * design.vibration)


def usual_move_times(models: Models, *, count: int) -> tuple[float, ...]:
    """Move times from what the drives just can to twice as long.

    The drives' top speed is where their voltage limit holds against their damping; the plain
    profile is half again as fast at its middle as on average.

    Args:
        models: The models.
        count: How many times, two at least.

    Returns:
        The times [s], in whole twentieths.
    """
    drive = models.ensemble.robot.drive
    top_speed = np.min(drive.voltage_limit * drive.torque_per_volt / drive.damping)
    radius = float(np.min(drive.effective_radius))
    longest = float(np.max(np.abs(models.end[:, 0] - models.ensemble.position[:, 0])))
    quickest = 1.5 * longest / (top_speed * radius)
    times = quickest * np.geomspace(_SHORTEST, _LONGEST, count)
    return tuple(float(np.ceil(20 * time) / 20) for time in times)
