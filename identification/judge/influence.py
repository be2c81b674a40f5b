r"""Which run moves which quantity, and how far the quantities move if other runs were logged.

At a fit's minimum the normal equations of every run are at hand. With the run's own
circumstances taken off by a Schur complement, run $g$ holds the information $S_g$ and the
pull $s_g$ on the shared quantities, and the pulls cancel. Counting run $g$ $w_g$ times moves
the quantities, to first order, by the Gauss-Newton step

$$ \delta(w) = -\Big( \sum_g w_g S_g \Big)^{-1} \sum_g w_g s_g , $$

so leaving a run out ($w_g = 0$) or drawing the runs anew ($w$ multinomial) is a solve with
as many unknowns as there are quantities, instead of a fit. While the residuals are noise that
is as good as a fit; where channels count by the logarithm of their misfit their weights would
follow, and the step is some half of the way.
"""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float
from scipy import special
from scipy.optimize import lsq_linear

from identification.fit.problem import Problem
from identification.fit.run_sums import RunSums
from identification.fit.unknowns.unknowns import lower_bound
from identification.judge.uncertainty import ParameterEstimate
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.robot.quantities import quantity

RESAMPLES = 4000
"""Resamples of the bootstrap: with five runs its interval ends at the fourth of them."""

FEWEST = 5.0
"""Runs that must tell a quantity for a bootstrap [1]: from five on the intervals of drawn runs,
equal or not, hold the truth in 93 to 98 %, with four in 86 %."""

LEAST_SHARE = 1e-6
"""Share of its information that a quantity must keep to count as told [1]: its standard error
is then a thousand times that of all runs."""

RIDGE = 1e-13
"""What information is filled up with, over that of all runs [1]: beyond its rounding."""

Interval = tuple[float, float]
"""Lower and upper end [SI]."""


@dataclasses.dataclass(frozen=True, eq=False)
class RunNormal:
    """Runs' normal equations in the shared quantities, their own circumstances eliminated."""

    runs: tuple[str, ...]
    """Names of the fitted runs."""
    information: Float[np.ndarray, "runs n n"]
    """Information of each run, over the quantities as a fit holds them."""
    pull: Float[np.ndarray, "runs n"]
    """Weighted $J^Tr$ of each run; with `otherwise` they cancel at a minimum."""
    otherwise: Normal
    """The part of what was measured otherwise, which stays whichever runs are there."""


@dataclasses.dataclass(frozen=True, eq=False)
class Influence:
    """Which run moves which quantity, and the bootstrap over runs."""

    names: tuple[tuple[str, str | None], ...]
    """Name and setting of each estimated quantity."""
    runs: tuple[str, ...]
    """Names of the fitted runs."""
    without: Float[np.ndarray, "runs quantities"]
    """Value of each quantity with a run left out [SI]; NaN where no other run tells it."""
    moved: Float[np.ndarray, "runs quantities"]
    """By how many of its standard errors that moves the quantity [1]."""
    by_noise: Float[np.ndarray, "runs quantities"]
    """By how many noise of the stated size alone would, root mean square [1]."""
    telling: Float[np.ndarray, " quantities"]
    """How many runs tell each quantity: as many equal ones would share it out as evenly [1]."""
    interval95: tuple[Interval | None, ...]
    """Interval of each quantity from the bootstrap over runs [SI]; None with too few runs."""
    resamples: int
    """Resamples of the bootstrap."""
    seed: int
    """Seed of the bootstrap."""
    refitted: bool = False
    """Whether the runs were left out by fits rather than by a Gauss-Newton step each."""


def run_normal(
    problem: Problem, point: Float[np.ndarray, " n"], of_runs: Mapping[int, RunSums]
) -> RunNormal:
    """The normal equations of every fitted run in the quantities that a fit may change.

    Args:
        problem: The problem.
        point: The fit's minimum.
        of_runs: What each fitted run adds at the fit's minimum, by its number.

    Returns:
        Information and pull of each run.
    """
    unknowns = problem.unknowns
    opened = np.flatnonzero(unknowns.opened)
    names, information, pull = [], [], []
    for run, sums in of_runs.items():
        inner, slope = _eliminated(sums, len(unknowns.free), unknowns.active[run])
        # Quantities that share an unknown add up in it.
        to = unknowns.local[run][:, None] == opened[None, :]
        names.append(problem.logs.runs[run].name)
        information.append(to.T @ inner @ to)
        pull.append(to.T @ slope)
    size, other = len(opened), problem.otherwise(point)
    return RunNormal(
        tuple(names),
        np.reshape(information, (len(names), size, size)),
        np.reshape(pull, (len(names), size)),
        Normal(other.cost, other.gradient[opened], other.matrix[np.ix_(opened, opened)]),
    )


def influence(
    normal: RunNormal,
    parameters: Sequence[ParameterEstimate],
    *,
    encoded: Float[np.ndarray, " n"],
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Influence:
    r"""Leave-one-run-out and bootstrap over runs, each by one Gauss-Newton step.

    The bootstrap's intervals are expanded percentiles: those at
    $\Phi\big(\pm t_{m-1} \sqrt{m/(m-1)}\big)$, with $m$ the runs that tell a quantity. Plain
    ones are too short with few runs.

    References: B. Efron, "Bootstrap methods: another look at the jackknife", Ann. Statist.
    7(1), 1979, doi:10.1214/aos/1176344552; T. C. Hesterberg, "What teachers should know
    about the bootstrap", Am. Stat. 69(4), 2015, doi:10.1080/00031305.2015.1089789.

    Args:
        normal: The runs' normal equations at the minimum.
        parameters: The estimated quantities, in the order of the normal equations.
        encoded: The minimum, in the quantities as a fit holds them.
        resamples: Resamples of the bootstrap.
        seed: Seed of the resamples.

    Returns:
        What moves what, and intervals.
    """
    names, count = [p.name for p in parameters], len(normal.runs)
    lower = np.array([lower_bound(name) for name in names]) - encoded
    without = decoded(names, encoded + moves(normal, 1.0 - np.eye(count), lower=lower))
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), resamples)
    resampled = decoded(names, encoded + moves(normal, drawn.astype(float), lower=lower))
    free = _unstopped(normal, lower)
    telling = telling_runs(free)
    (value,) = decoded(names, encoded[None])
    # A logarithm's standard error is relative.
    size = np.where([quantity(name).positive for name in names], value, 1.0)
    sigma = standard_errors(parameters)
    return Influence(
        names=tuple((p.name, p.setting) for p in parameters),
        runs=normal.runs,
        without=without,
        moved=(without - value) / sigma,
        by_noise=_by_noise(free) * size / sigma,
        telling=telling,
        interval95=tuple(map(_expanded, resampled.T, telling)),
        resamples=resamples,
        seed=seed,
    )


def moves(
    normal: RunNormal,
    weights: Float[np.ndarray, "cases runs"],
    *,
    lower: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "cases n"]:
    """By how far the quantities move if every run counts a number of times.

    Args:
        normal: The runs' normal equations at the minimum.
        weights: How often each run counts.
        lower: Least move that each quantity's bound allows.

    Returns:
        Their moves as a fit holds them; NaN for a quantity that the runs that count don't
        tell.
    """
    inverse = _covariances(normal, weights)
    pull = weights @ normal.pull + normal.otherwise.gradient
    moved = -np.einsum("cij,cj->ci", inverse, pull)
    is_determined = _is_determined(normal, inverse)
    for case in np.flatnonzero(np.any(is_determined & (moved < lower), axis=1)):
        at = np.flatnonzero(is_determined[case])
        moved[case, at] = _bounded(inverse[case][np.ix_(at, at)], moved[case, at], lower[at])
    return np.where(is_determined, moved, np.nan)


def telling_runs(normal: RunNormal) -> Float[np.ndarray, " n"]:
    r"""How many runs tell each quantity.

    With $C = (\sum_g S_g)^{-1}$, run $g$ has a part $p_g = (C S_g C)_{jj}$ in the variance of
    quantity $j$; $(\sum p_g)^2 / \sum p_g^2$ is the number of runs if all parts are equal, and
    1 if a single run has it all.

    Args:
        normal: The runs' normal equations.

    Returns:
        One number for each quantity; 0 for one that no run tells.
    """
    (inverse,) = _covariances(normal, np.ones((1, len(normal.runs))))
    part = np.einsum("ij,gjk,ki->gi", inverse, normal.information, inverse)
    squares = np.sum(np.square(part), axis=0)
    every = np.square(part.sum(axis=0))
    return np.where(squares > 0, every / np.where(squares > 0, squares, 1.0), 0.0)


def _eliminated(
    sums: RunSums, count: int, active: Bool[np.ndarray, " circumstances"]
) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, " n"]]:
    """A run's information and pull on its first `count` unknowns, the others solved for."""
    matrix, pull = sums.matrix, sums.gradient
    others = count + np.flatnonzero(active)
    across = matrix[:count, others] @ _inverse(matrix[np.ix_(others, others)])
    return (
        matrix[:count, :count] - across @ matrix[others, :count],
        pull[:count] - across @ pull[others],
    )


def _inverse(matrix: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """Inverse of an information matrix over what it tells, 0 elsewhere."""
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > 0, 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), 0.0)
    both = np.outer(scale, scale)
    return np.linalg.pinv(matrix * both, hermitian=True) * both


def _covariances(
    normal: RunNormal, weights: Float[np.ndarray, "cases runs"]
) -> Float[np.ndarray, "cases n n"]:
    """Covariance of the quantities by the noise alone, each run counted a number of times.

    What is told by nothing has a large variance instead of an infinite one.
    """
    otherwise = normal.otherwise.matrix
    whole = np.diag(normal.information.sum(axis=0) + otherwise)
    scale = 1 / np.sqrt(np.where(whole > 0, whole, 1.0))
    both = np.outer(scale, scale)
    information = np.einsum("cg,gij->cij", weights, normal.information) + otherwise
    return np.linalg.inv(information * both + RIDGE * np.eye(scale.size)[None]) * both[None]


def _is_determined(
    normal: RunNormal, covariances: Float[np.ndarray, "cases n n"]
) -> Bool[np.ndarray, "cases n"]:
    """Which quantities keep enough of the information that all runs hold."""
    (whole,) = _covariances(normal, np.ones((1, len(normal.runs))))
    variance = np.diagonal(covariances, axis1=1, axis2=2)
    return (variance > 0) & (LEAST_SHARE * variance < np.diag(whole)[None])


def _by_noise(normal: RunNormal) -> Float[np.ndarray, "runs n"]:
    """Standard deviation of the move that leaving out each run makes, by the noise alone.

    The whole fit is the efficient one, so the variances of the two fits differ by that of
    their difference.
    """
    count = len(normal.runs)
    (whole,) = _covariances(normal, np.ones((1, count)))
    rest = _covariances(normal, 1.0 - np.eye(count))
    variance = np.diagonal(rest, axis1=1, axis2=2) - np.diag(whole)[None]
    return np.where(_is_determined(normal, rest), np.sqrt(np.maximum(variance, 0.0)), np.nan)


def _bounded(
    covariance: Float[np.ndarray, "n n"],
    step: Float[np.ndarray, " n"],
    lower: Float[np.ndarray, " n"],
) -> Float[np.ndarray, " n"]:
    """The step to a quadratic model's minimum within lower bounds, from that without."""
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    # What rounding leaves of a combination that is known far better than its quantities.
    root = np.sqrt(np.maximum(values, np.finfo(float).eps * values[-1]))
    factor = (vectors / root).T
    target = factor @ (step / scale)
    # A start at its bound may be beyond it by rounding.
    bounds = (np.minimum(lower / scale, -1e-12), np.inf)
    return scale * lsq_linear(factor, target, bounds, method="bvls").x


def _unstopped(normal: RunNormal, lower: Float[np.ndarray, " n"]) -> RunNormal:
    """The normal equations without the quantities that their bound stops."""
    other = normal.otherwise
    free = (lower < 0) | (normal.pull.sum(axis=0) + other.gradient <= 0)
    both = np.outer(free, free)
    return dataclasses.replace(
        normal,
        information=normal.information * both,
        otherwise=dataclasses.replace(other, matrix=other.matrix * both),
    )


def standard_errors(parameters: Sequence[ParameterEstimate]) -> Float[np.ndarray, " n"]:
    """Standard errors of quantities.

    Args:
        parameters: The quantities.

    Returns:
        Standard errors [SI]; NaN for what has none.
    """
    sigma = np.array([p.sigma for p in parameters])
    return np.where(np.isfinite(sigma) & (sigma > 0), sigma, np.nan)


def decoded(
    names: Sequence[str], encoded: Float[np.ndarray, "cases n"]
) -> Float[np.ndarray, "cases n"]:
    """Values of quantities from how a fit holds them.

    Args:
        names: Their names.
        encoded: What a fit holds in each of some cases.

    Returns:
        Their values [SI].
    """
    # A step of a fit that has failed may lead anywhere.
    with np.errstate(over="ignore"):
        columns = [
            np.exp(column) if quantity(name).positive else column
            for name, column in zip(names, encoded.T, strict=True)
        ]
    return np.stack(columns, axis=1)


def _expanded(drawn: Float[np.ndarray, " resamples"], telling: float) -> Interval | None:
    """Expanded percentiles; None with too few runs, or too few that tell it."""
    values = drawn[~np.isnan(drawn)]
    if telling < FEWEST or values.size < 0.99 * drawn.size:
        return None
    far = special.stdtrit(telling - 1, 0.975) * np.sqrt(telling / (telling - 1))
    low, high = np.quantile(values, special.ndtr([-far, far]))
    return float(low), float(high)
