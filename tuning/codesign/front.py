"""The least vibration of the worst models for every move time: the Pareto front of both."""

import itertools
from collections.abc import Sequence

import numpy as np

from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.codesign.designed import Designed, ranked
from tuning.codesign.models import Models
from tuning.codesign.search import Designer, Search, Start, in_turn
from tuning.loop.admissible import Admissible

_SHORTEST, _LONGEST = 1.2, 2.1
"""Ends of the front over the time in which the drives' top speed would do the longest leg at
the plain profile [1]: half again as fast as its mean it is at its middle."""
_BESIDE = 2
"""Designs of a move time that those beside are begun from: the best one may be another minimum
than the one that leads on."""


def front(
    models: Models,
    within: Admissible,
    *,
    move_times: Sequence[float],
    designer: Designer = in_turn,
    progress: Progress = SILENT,
) -> tuple[Designed, ...]:
    """A design for each of some move times, the vibration never rising with the time.

    Who has more time may move as fast as with less, and wait: a longer move that turns out
    worse than a shorter one isn't on the front.

    Args:
        models: The models.
        within: Which gains are admissible.
        move_times: Times of the moves, the shaper included [s].
        designer: Who descends from the starts of all times: they are independent.
        progress: Told what is being done and which share of it is done.

    Returns:
        A design for each time, the shortest first, without those times in which the drives
        can't keep within their limit, and those that a shorter one beats.

    Raises:
        ValueError: If they can't in any.
    """
    search = Search(models, within, max(move_times))
    designs = _least(search, sorted(move_times), designer, progress)
    limit = float(np.min(models.ensemble.robot.drive.voltage_limit))
    falling: list[Designed] = []
    for design in designs:
        beaten = falling and design.vibration > falling[-1].vibration
        if design.keeps_voltage(limit) and not beaten:
            falling.append(design)
    if not falling:
        raise ValueError(
            f"`move_times` are too short for the drives, got {search.longest:.3g} s at the "
            f"longest [s], in which the worst model needs more than {limit:g} V. Give the move "
            "more time, or shorten the legs."
        )
    return tuple(falling)


def _least(
    search: Search, times: Sequence[float], designer: Designer, progress: Progress
) -> list[Designed]:
    """The design of least cost for each time, without times in which not even a shaper ends.

    Two rounds: the catalogue's shapers, then what the best of these end in, for the times
    beside.
    """
    starts = []
    for number, time in enumerate(times):
        progress("co-design: shapers of the catalogue", 0.1 * number / len(times))
        starts.append(search.starts(time))
    ends = _grouped(search, starts, designer, progress.part(0.1, 0.6))
    first = [ranked(each, search.models) for each in ends if each]
    beside = [
        [
            Start(each.point, own[0].move_time)
            for neighbour in (*first[:i][-1:], *first[i + 1 :][:1])
            for each in neighbour[:_BESIDE]
        ]
        for i, own in enumerate(first)
    ]
    ends = _grouped(search, beside, designer, progress.part(0.6, 1.0))
    return [
        ranked([*own, *each], search.models)[0] for own, each in zip(first, ends, strict=True)
    ]


def _grouped(
    search: Search,
    starts: Sequence[Sequence[Start]],
    designer: Designer,
    progress: Progress,
) -> list[list[Designed]]:
    """The designs that groups of starts end in."""
    every = list(itertools.chain.from_iterable(starts))
    # A single move time has none beside it, and one that is too short has no start.
    ends = iter(designer(search, every, progress) if every else ())
    return [list(itertools.islice(ends, len(each))) for each in starts]


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
