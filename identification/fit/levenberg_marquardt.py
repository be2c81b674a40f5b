"""Levenberg-Marquardt on normal equations that somebody else accumulates."""

from collections.abc import Callable, Generator, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float


class Normal(NamedTuple):
    """A misfit at a point, with its Gauss-Newton model."""

    cost: float
    """The misfit."""
    gradient: Float[np.ndarray, " n"]
    r"""Weighted $J^T r$, half the gradient of the misfit."""
    matrix: Float[np.ndarray, "n n"]
    r"""Weighted $J^T J$, half the Gauss-Newton model's second derivative."""

    def plus(self, other: "Normal") -> "Normal":
        """The normal equations of both misfits together.

        Args:
            other: Those of another misfit of the same unknowns.

        Returns:
            Their sums.
        """
        return Normal(*(mine + theirs for mine, theirs in zip(self, other, strict=True)))


class Minimum(NamedTuple):
    """Where a minimisation ended."""

    point: Float[np.ndarray, " n"]
    """The best point found."""
    normal: Normal
    """Cost and Gauss-Newton model there."""
    iterations: int
    """Evaluations of the normal equations."""
    ended: str
    """`converged`; `stalled` where no step helps any more, as at a kink of the friction;
    or `unfinished`."""


def minimise(
    evaluate: Callable[[Float[np.ndarray, " n"]], Normal],
    start: Float[np.ndarray, " n"],
    *,
    lower: Float[np.ndarray, " n"],
    iterations: int,
    decrement: float,
    report: Callable[[int, float], None] = lambda iteration, cost: None,
) -> Minimum:
    r"""Minimum of a sum of squares within lower bounds.

    A step solves $(J^TJ + \lambda\, \mathrm{diag}\, J^TJ)\,\delta = -J^T r$ over the
    unknowns that are free to move: those that the data see, and that no bound stops.

    Reference: D. W. Marquardt, "An algorithm for least-squares estimation of nonlinear
    parameters", SIAM J. Appl. Math. 11(2), 1963, doi:10.1137/0111030.

    Args:
        evaluate: The normal equations at a point.
        start: Where to begin.
        lower: Lower bounds, minus infinity for none.
        iterations: Most evaluations of the normal equations.
        decrement: Decrease of the cost that a step still has to promise; a millionth of
            the cost is enough where that is more.
        report: Called with the evaluations so far and the best cost.

    Returns:
        The best point, converged or not.
    """
    search = _search(start, lower=lower, iterations=iterations, decrement=decrement)
    wanted, done, best = next(search), 0, np.inf
    while not isinstance(wanted, Minimum):
        found, done = evaluate(wanted), done + 1
        best = min(best, found.cost)
        report(done, best)
        wanted = search.send(found)
    return wanted


def minimise_together(
    evaluate: Callable[[list[Float[np.ndarray, " n"]]], list[Normal]],
    starts: Sequence[Float[np.ndarray, " n"]],
    *,
    lower: Float[np.ndarray, " n"],
    iterations: int,
    decrement: float,
    share: float = 1e-6,
) -> list[Minimum]:
    """Minima from several starts, whose evaluations are made together.

    Args:
        evaluate: The normal equations at each of some points.
        starts: Where to begin.
        lower: Lower bounds, minus infinity for none.
        iterations: Most evaluations of each start.
        decrement: As in `minimise`.
        share: Share of the cost that is enough where that is more.

    Returns:
        Where each start ended.
    """
    searches = [
        _search(start, lower=lower, iterations=iterations, decrement=decrement, share=share)
        for start in starts
    ]
    wanted = [next(search) for search in searches]
    while open_ones := [k for k, w in enumerate(wanted) if not isinstance(w, Minimum)]:
        found = evaluate([wanted[k] for k in open_ones])
        for k, normal in zip(open_ones, found, strict=True):
            wanted[k] = searches[k].send(normal)
    return wanted


def _search(
    start: Float[np.ndarray, " n"],
    *,
    lower: Float[np.ndarray, " n"],
    iterations: int,
    decrement: float,
    share: float = 1e-6,
) -> Generator[Float[np.ndarray, " n"] | Minimum, Normal, None]:
    """The algorithm: yields the points that it wants evaluated, and its minimum at last."""
    point, damping = np.maximum(start, lower), 1e-3
    best, done, ended = (yield point), 1, "unfinished"
    while done < iterations:
        step, promised = _step(best, point, lower, damping)
        if promised <= max(decrement, share * abs(best.cost)):
            # A long step that promises nothing is the end; a damped one stands at a kink.
            ended = "converged" if damping <= 1e-2 else "stalled"
            break
        candidate = np.maximum(point + step, lower)
        tried, done = (yield candidate), done + 1
        if np.isfinite(tried.cost) and tried.cost < best.cost:
            point, best, damping = candidate, tried, max(damping / 10, 1e-9)
        else:
            damping = max(damping * 10, 1e-3)
    yield Minimum(point, best, done, ended)


def free_unknowns(
    normal: Normal, point: Float[np.ndarray, " n"], lower: Float[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """The unknowns that the data see and that no bound stops.

    Args:
        normal: The normal equations at the point.
        point: The point.
        lower: Lower bounds.

    Returns:
        True for each unknown that may move.
    """
    stopped = (point <= lower) & (normal.gradient > 0)
    return (np.diag(normal.matrix) > 0) & ~stopped


def _step(
    normal: Normal,
    point: Float[np.ndarray, " n"],
    lower: Float[np.ndarray, " n"],
    damping: float,
) -> tuple[Float[np.ndarray, " n"], float]:
    """A damped step, and by how much it promises to lower the cost."""
    free = np.flatnonzero(free_unknowns(normal, point, lower))
    scale = 1 / np.sqrt(np.diag(normal.matrix)[free])
    scaled = normal.matrix[np.ix_(free, free)] * np.outer(scale, scale)
    gradient = normal.gradient[free] * scale
    solution = np.linalg.solve(scaled + damping * np.eye(free.size), -gradient)
    step = np.zeros_like(point)
    step[free] = scale * solution
    promised = -(2 * gradient @ solution + solution @ scaled @ solution)
    return step, float(promised)
