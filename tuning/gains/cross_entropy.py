"""A search by sampling: cross entropy.

A loss with many minima and kinks has no use for one gradient. A normal distribution is drawn
from, and moved to the best quarter of what it gave, weighed by rank: only the order of the
losses counts, so that one that explodes does no harm.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.progress import SILENT, Progress


class Search(NamedTuple):
    """A normal distribution over flat designs, and the best design seen."""

    mean: Float[np.ndarray, " n"]
    """Its mean."""
    spread: Float[np.ndarray, "n n"]
    """Its covariance."""
    best: Float[np.ndarray, " n"]
    """The best design seen."""
    loss: float
    """Its loss [1]."""


def cross_entropy(
    losses: Callable[[Float[np.ndarray, "population n"]], Float[np.ndarray, " population"]],
    start: Float[np.ndarray, " n"],
    spread: Float[np.ndarray, "n n"],
    *,
    population: int,
    generations: int,
    seed: int,
    progress: Progress = SILENT,
) -> Search:
    """The best of some generations.

    Args:
        losses: Loss of each of some designs.
        start: Mean of the first generation.
        spread: Its covariance.
        population: Designs of a generation.
        generations: Generations.
        seed: Of the random numbers.
        progress: Told which share of the generations is done.

    Returns:
        Where the search ended.
    """
    search = Search(start, spread, start, np.inf)
    random = np.random.default_rng(seed)
    for generation in range(generations):
        progress("", generation / generations)
        designs = random.multivariate_normal(search.mean, search.spread, population)
        designs[0] = search.best
        search = _learn(search, designs, losses(designs))
    return search


def _learn(
    search: Search,
    designs: Float[np.ndarray, "population n"],
    losses: Float[np.ndarray, " population"],
) -> Search:
    """The distribution moved to a generation's best quarter, as in cross entropy."""
    losses = np.where(np.isfinite(losses), losses, np.inf)
    order = np.argsort(losses)
    elite = designs[order[: max(len(order) // 4, 2)]]
    weights = np.log(len(elite) + 0.5) - np.log(np.arange(1, len(elite) + 1))
    weights /= weights.sum()
    away = elite - search.mean
    spread = (away * weights[:, None]).T @ away
    better = losses[order[0]] < search.loss
    return Search(
        mean=0.3 * search.mean + 0.7 * (weights @ elite),
        spread=0.5 * (search.spread + spread) + 1e-5 * np.eye(len(search.mean)),
        best=designs[order[0]] if better else search.best,
        loss=float(losses[order[0]]) if better else search.loss,
    )
