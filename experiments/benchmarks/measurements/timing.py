"""Times of calls that take turns, so that a busy machine is busy for all of them."""

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import numpy as np


class Timed(NamedTuple):
    """What a call gave and how long it took."""

    result: Any
    """Of its first time."""
    compile: float
    """How much longer its first time took than the median [s]."""
    median: float
    """Median of the later times [s]."""


def interleaved(calls: Mapping[str, Callable[[], Any]], *, repeats: int) -> dict[str, Timed]:
    """Call each once, then all of them in turn, again and again.

    Args:
        calls: What to call, by name.
        repeats: How often after the first time.

    Returns:
        Results and times by name.
    """
    first = {name: _once(call) for name, call in calls.items()}
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            times[name].append(_once(call)[1])
    medians = {name: statistics.median(row) for name, row in times.items()}
    return {
        name: Timed(result, max(took - medians[name], 0.0), medians[name])
        for name, (result, took) in first.items()
    }


def fastest(calls: Mapping[int, Callable[[], Any]]) -> int:
    """Which call is fastest, compiled.

    Args:
        calls: What to call, by a number.

    Returns:
        The number of the call with the least of three times.
    """
    for call in calls.values():
        _once(call)
    least = {n: min(_once(call)[1] for _ in range(3)) for n, call in calls.items()}
    return min(least, key=lambda n: least[n])


def _once(call: Callable[[], Any]) -> tuple[Any, float]:
    begun = time.perf_counter()
    result = jax.tree.map(np.asarray, jax.block_until_ready(call()))
    return result, time.perf_counter() - begun
