"""A million poses' natural frequencies."""

import resource
from collections.abc import Iterator

import jax
import numpy as np
from jaxtyping import Array, Float

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements.timing import interleaved
from scdpr_jax.linear.modes import LOWER_HELD, natural_frequencies
from scdpr_jax.numerics.batches import chunks
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

POINTS = 1_000_000
"""Points, of three frequencies each."""
CHUNK = 8192
"""Points at a time."""


def _frequencies(point: Float[Array, "2"]) -> Float[Array, "3"]:
    prototype = jax.tree.map(lambda leaf: leaf.astype(point.dtype), consistent())
    robot = replace(prototype, {"effective_pretension": point[1]})
    return natural_frequencies(robot, point[0], LOWER_HELD)


def million(settings: Settings) -> Iterator[Line]:
    """Natural frequencies over height and pretension.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    random = np.random.default_rng(7)
    points = random.uniform([0.2, 50.0], [0.9, 300.0], (POINTS, 2))
    single = points.astype(np.float32)
    before = _peak()

    def highest(grid: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, ""]:
        # What a sweep does with each chunk is its own affair; here it is let go.
        return max(chunk.max() for chunk in chunks(_frequencies, grid, size=CHUNK))

    times = interleaved(
        {"float32": lambda: highest(single), "float64": lambda: highest(points)},
        repeats=settings.repeats,
    )
    grown = (_peak() - before) / 1e6
    for name, timed in times.items():
        yield Line(
            row=f"{POINTS:,} frequency points",
            contender=f"this, {name}",
            batch=POINTS,
            median=timed.median,
            rate=3 * POINTS / timed.median,
            unit="frequency",
            compile=timed.compile,
            error=f"{abs(timed.result / times['float64'].result - 1):.1e} of float64's highest",
            note=f"lower carriage held; peak memory grew by {grown:.0f} MB, both precisions",
        )


def _peak() -> float:
    """Largest resident memory so far [B]."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
