r"""Levenberg and Marquardt's method, as a search that asks for evaluations.

What is minimised is a merit with a Gauss–Newton model: a sum of squared residuals, or the mean
of the worst of many. Where the residuals are a simulation's, an evaluation takes seconds and
the algorithm nothing, and every use evaluates in its own way: in chunks over the runs of a
campaign, for several starts in one batch, for the worst models alone. So the search is a
generator. It yields the point that it wants evaluated, is sent the evaluation, and yields its
minimum at last; `minimise` drives one, `minimise_together` several whose evaluations are made
at once. Fits that are lanes of one compiled program share `damped_step`.

A step solves $(M + \lambda D)\, \delta = -g$ over the unknowns that are free to move, with the
gradient $g = J^T r$, the matrix $M = J^T J$ and its diagonal $D$: in units of the
unknowns' own, which are logarithms, metres and seconds at once. Steps without damping
(Gauss–Newton) would be simpler; they jump out of the valley that a start is in, as the
vibration's phase wraps, and they blow up along what the data hardly tell. A bound stops an
unknown that would cross it and leaves the others their step; clipping the whole step bends it.
An unknown that hardly acts any more, as a velocity does of a surplus that has come to nothing,
has a step of hundreds of its own units, and the next derivative overflows: that is clipped.
Where a run only just stops, friction puts a kink into the merit: no step helps any more though
the model promises one, and the search ends as `stalled`.

References: K. Levenberg, "A method for the solution of certain non-linear problems in least
squares", Quart. Appl. Math. 2(2), 1944, doi:10.1090/qam/10666. D. W. Marquardt, "An algorithm
for least-squares estimation of nonlinear parameters", J. SIAM 11(2), 1963,
doi:10.1137/0111030. H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05,
Technical University of Denmark, 1999: `Damping.growth`.
"""

import dataclasses
import math
from collections.abc import Callable, Generator, Sequence
from typing import Any, Generic, TypeVar

import numpy as np
from jaxtyping import Bool, Float

from scdpr_jax.numerics.merit import Merit
from scdpr_jax.numerics.progress import SILENT, Progress


@dataclasses.dataclass(frozen=True)
class Damping:
    r"""How the damping $\lambda$ follows from whether steps helped."""

    first: float = 1e-3
    """Damping of the first step [1]."""
    fall: float = 10.0
    """By what it is divided after a step that helped [1]."""
    rise: float = 10.0
    """By what it is multiplied after a step that didn't [1]."""
    growth: float = 1.0
    """By what that factor grows with every further step in a row that doesn't help [1]."""
    least: float = 1e-9
    """Below this it doesn't fall [1]."""
    again: float = 0.0
    """Least damping after a step that didn't help [1]."""
    most: float = math.inf
    """Damping above which no step is tried: it would lead nowhere [1]."""
    floor: float = 0.0
    r"""Share of the trace of $M$ that is added to each element of $D$ [1]: damps a direction
    that moves almost nothing."""

    def lowered(self, damping: float) -> float:
        """The damping after a step that helped.

        Args:
            damping: The step's [1].

        Returns:
            The next one's [1].
        """
        return max(damping / self.fall, self.least)

    def raised(self, damping: float, rejections: int) -> float:
        """The damping after a step that didn't help.

        Args:
            damping: The step's [1].
            rejections: How many steps in a row didn't, 1 or more.

        Returns:
            The next one's [1].
        """
        return max(damping * self.rise * self.growth ** (rejections - 1), self.again)


@dataclasses.dataclass(frozen=True)
class Stopping:
    """When a search ends."""

    evaluations: int | None = None
    """Most evaluations, the first one included; None for any number."""
    steps: int | None = None
    """Most steps that helped; None for any number."""
    rejections: int | None = None
    """Steps in a row that don't help, after which a point counts as a minimum or a kink."""
    decrement: float = 0.0
    """Decrease of the merit that a step has to promise [the merit's unit]."""
    share: float = 1e-6
    """Share of the merit that it has to promise where that is more [1]: a millionth moves an
    unknown by a thousandth of the residuals' norm."""
    saving: float = 0.0
    """Share of the merit that a step has to save for another to follow [1]."""
    undamped: bool = False
    """Whether the promise that counts is that of a step without damping: beside a kink the
    search then goes on with ever shorter steps."""

    def share_used(self, evaluations: int, steps: int) -> float:
        """How much of what is allowed has been used.

        Args:
            evaluations: Evaluations so far.
            steps: Steps so far that helped.

        Returns:
            Share of the evaluations or of the steps [1], whichever is more.
        """
        used = ((evaluations, self.evaluations), (steps, self.steps))
        return max(
            (done / most if most else 1.0 for done, most in used if most is not None),
            default=0.0,
        )


AMerit = TypeVar("AMerit", bound=Merit)
Point = Float[np.ndarray, " n"]


@dataclasses.dataclass(frozen=True, eq=False)
class Minimum(Generic[AMerit]):
    """Where a minimisation ended."""

    point: Point
    """The best point that was tried."""
    normal: AMerit
    """Merit and Gauss–Newton model there."""
    iterations: int
    """Evaluations."""
    ended: str
    """`converged`; `stalled` where no step helps any more, as at a kink of the friction;
    `unfinished`; or `infeasible` where the start has no finite merit."""
    history: tuple[float, ...]
    """Merit at the start and after each step that helped."""


MARQUARDT = Damping(again=1e-3)
"""The damping of a fit."""
_REGULAR = 1e-9
"""Damping that keeps what can't be told apart from breaking a solution [1]."""


def minimise(
    evaluate: Callable[[Point], AMerit],
    start: Point,
    *,
    stopping: Stopping,
    lower: Point | None = None,
    longest: Point | None = None,
    damping: Damping = MARQUARDT,
    progress: Progress = SILENT,
) -> Minimum[AMerit]:
    """The minimum that a start leads to.

    Args:
        evaluate: The merit at a point.
        start: Where to begin.
        stopping: When to end.
        lower: Lower bounds; None for none.
        longest: Longest step of each unknown; None for any.
        damping: How the damping follows from the steps.
        progress: Told which share of what is allowed has been used.

    Returns:
        The best point, converged or not.
    """
    search = _search(start, lower=lower, longest=longest, damping=damping, stopping=stopping)
    request, evaluations, steps, best = next(search), 0, -1, math.inf
    while not isinstance(request, Minimum):
        merit = evaluate(request)
        evaluations += 1
        if merit.cost < best:
            best, steps = merit.cost, steps + 1
        progress("", stopping.share_used(evaluations, steps))
        request = search.send(merit)
    return request


def minimise_together(
    evaluate: Callable[[list[Point]], list[AMerit]],
    starts: Sequence[Point],
    *,
    stopping: Stopping,
    lower: Point | None = None,
    longest: Point | None = None,
    damping: Damping = MARQUARDT,
) -> list[Minimum[AMerit]]:
    """The minima that several starts lead to, their evaluations made at once.

    Args:
        evaluate: The merits at some points.
        starts: Where to begin.
        stopping: When each of them is to end.
        lower: Lower bounds; None for none.
        longest: Longest step of each unknown; None for any.
        damping: How the damping follows from the steps.

    Returns:
        Where each start ended.
    """
    searches = [
        _search(start, lower=lower, longest=longest, damping=damping, stopping=stopping)
        for start in starts
    ]
    requests = [next(search) for search in searches]
    while rows := [k for k, r in enumerate(requests) if not isinstance(r, Minimum)]:
        merits = evaluate([requests[k] for k in rows])
        for k, merit in zip(rows, merits, strict=True):
            requests[k] = searches[k].send(merit)
    return requests


def _search(
    start: Point,
    *,
    lower: Point | None,
    longest: Point | None,
    damping: Damping,
    stopping: Stopping,
) -> Generator[Point | Minimum[AMerit], AMerit, None]:
    """The algorithm: yields the points that it wants evaluated, and its minimum at last."""
    lower = np.full(len(start), -np.inf) if lower is None else lower
    point = np.maximum(start, lower)
    best = yield point
    history, evaluations, rejections, weight = [best.cost], 1, 0, damping.first
    ended = "unfinished" if np.isfinite(best.cost) else "infeasible"
    while ended == "unfinished" and not stopping.share_used(evaluations, len(history) - 1) >= 1:
        step, promised = _step(best, point, lower, longest, weight, damping.floor)
        if stopping.undamped:
            _, promised = _step(best, point, lower, longest, _REGULAR, damping.floor)
        if promised <= max(stopping.decrement, stopping.share * abs(best.cost)):
            # A long step that promises nothing is the end; a damped one stands at a kink.
            ended = "converged" if weight <= 1e-2 and promised > -math.inf else "stalled"
            break
        candidate = np.maximum(point + step, lower)
        merit, evaluations = (yield candidate), evaluations + 1
        if np.isfinite(merit.cost) and merit.cost < best.cost:
            if best.cost - merit.cost < stopping.saving * abs(merit.cost):
                ended = "converged"
            point, best, rejections = candidate, merit, 0
            weight = damping.lowered(weight)
            history.append(best.cost)
        else:
            rejections += 1
            weight = damping.raised(weight, rejections)
            if weight > damping.most or rejections == stopping.rejections:
                ended = "stalled"
    yield Minimum(point, best, evaluations, ended, tuple(history))


def settled(
    minimum: Minimum[AMerit], lower: Point, longest: Point | None = None
) -> Minimum[AMerit]:
    """A minimum after the step that promised too little to be evaluated.

    It costs nothing, and leaves of the distance what its square is: two searches of the same
    minimum end at the same point to some ten digits, by whichever way they came.

    Args:
        minimum: Where a search ended.
        lower: Its lower bounds.
        longest: Longest step of each unknown; None for any.

    Returns:
        The minimum with its point moved, its merit and model as they were; the same where the
        search didn't converge.
    """
    if minimum.ended != "converged":
        return minimum
    step, _ = _step(minimum.normal, minimum.point, lower, longest, _REGULAR, 0.0)
    return dataclasses.replace(minimum, point=np.maximum(minimum.point + step, lower))


def free_unknowns(normal: Merit, point: Point, lower: Point) -> Bool[np.ndarray, " n"]:
    """The unknowns that the data see and that no bound stops.

    Args:
        normal: The merit at the point.
        point: The point.
        lower: Lower bounds.

    Returns:
        True for each unknown that may move.
    """
    stopped = (point <= lower) & (normal.gradient > 0)
    return (np.diag(normal.matrix) > 0) & ~stopped


def _step(
    merit: Merit,
    point: Point,
    lower: Point,
    longest: Point | None,
    damping: float,
    floor: float,
) -> tuple[Point, float]:
    """A damped step, and by how much it promises to lower the merit."""
    free = free_unknowns(merit, point, lower)
    try:
        step = damped_step(merit.gradient, merit.matrix, damping, free=free, floor=floor)
    except np.linalg.LinAlgError:
        # Overflowed derivatives, and those of unknowns that act as one to the last digit.
        return np.zeros_like(point), -math.inf
    if longest is not None:
        step = np.clip(step, -longest, longest)
    return step, -float(2 * merit.gradient @ step + step @ merit.matrix @ step)


FloatArray = Float[Any, "*searches n"]
"""NumPy's or JAX's: naming JAX's would load it, and the doctor does without."""


def damped_step(
    gradient: FloatArray,
    matrix: Float[Any, "*searches n n"],
    damping: float | Float[Any, "*searches"],
    *,
    free: Bool[Any, "*searches n"] | None = None,
    floor: float = 0.0,
) -> FloatArray:
    r"""The step $\delta$ with $(M + \lambda D)\, \delta = -g$ over the free unknowns.

    It is solved in units in which $D$ is one, so that logarithms, metres and seconds round
    alike. The shapes don't depend on which unknowns are free, so it serves NumPy's arrays and
    those of a compiled program likewise, of one search or of many.

    Args:
        gradient: $g$, half the merit's gradient.
        matrix: $M$, half the second derivative of its Gauss–Newton model.
        damping: $\lambda$ [1].
        free: Which unknowns may move; None for all that the matrix sees.
        floor: Share of $M$'s trace that is added to each element of its diagonal in $D$ [1].

    Returns:
        The step; 0 for an unknown that isn't free, or that nothing depends on.
    """
    xp = gradient.__array_namespace__()
    identity = xp.eye(gradient.shape[-1], dtype=gradient.dtype)
    diagonal = xp.linalg.diagonal(matrix)
    diagonal = diagonal + floor * xp.sum(diagonal, axis=-1, keepdims=True)
    moves = diagonal > 0 if free is None else free & (diagonal > 0)
    scale = xp.where(moves, 1 / xp.sqrt(xp.where(moves, diagonal, 1.0)), 0.0)
    # An unknown that stays has an equation of its own.
    alone = xp.where(moves, xp.asarray(damping)[..., None], 1.0)[..., None] * identity
    unit = matrix * scale[..., None] * scale[..., None, :] + alone
    return -scale * xp.linalg.solve(unit, (gradient * scale)[..., None])[..., 0]
