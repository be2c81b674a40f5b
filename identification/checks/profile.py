r"""Profile likelihood: how the misfit rises as one quantity is held, the others fitted anew.

An interval from a covariance takes the misfit for a parabola. The profile doesn't: it may
rise on both sides, on one alone or not at all, which is what bounded, one-sided and flat say.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Campaign
from identification.fit.problem import Problem
from identification.fit.unknowns.unknowns import decode, encode
from identification.judge.likelihood import Profile
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimate import Estimate
from identification.result.estimation import solved
from scdpr_jax.numerics.levenberg_marquardt import Stopping, minimise_together
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.robot.quantities import quantity

WIDTHS = (-3.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 3.0)
"""Where a quantity is held, in half widths of its interval."""

FAR = (0.25, 0.5, 0.8, 0.9, 1.1, 1.25, 2.0, 4.0)
"""Where one without an interval is held, as multiples of its value [1]."""


def profile(
    campaign: Campaign,
    estimate: Estimate,
    *,
    names: Sequence[str] | None = None,
    iterations: int = 6,
) -> tuple[Profile, ...]:
    """Profiles of the estimated quantities, all points of a profile side by side.

    Args:
        campaign: The campaign that the estimate is of.
        estimate: The estimate.
        names: Names of the quantities, None for all that were estimated.
        iterations: Most evaluations at a point.

    Returns:
        Their profiles, in the estimate's order.
    """
    problem, point = solved(campaign, estimate)
    (best,) = problem.evaluate([point])
    return tuple(
        _profile(problem, point, best, parameter, iterations=iterations)
        for parameter in estimate.fitted.estimated
        if names is None or parameter.name in names
    )


def _profile(
    problem: Problem,
    point: Float[np.ndarray, " n"],
    best: Normal,
    parameter: ParameterEstimate,
    *,
    iterations: int,
) -> Profile:
    index = problem.unknowns.place(parameter.name, parameter.setting)
    grid = _grid(parameter)
    seen = np.flatnonzero(np.diag(best.matrix) > 0)
    others = seen[seen != index]
    # Along the valley's floor, as far as the misfit is a parabola.
    across = best.matrix[np.ix_(others, others)]
    along = -np.linalg.lstsq(across, best.matrix[others, index], rcond=None)[0]
    curvature = best.matrix[index, index] + best.matrix[index, others] @ along
    starts = []
    for number in grid:
        start = point.copy()
        start[index] = number
        start[others] += along * (number - point[index])
        starts.append(start)

    def evaluate(points: list[np.ndarray]) -> list[Normal]:
        return [_without(normal, index) for normal in problem.evaluate(points)]

    ends = minimise_together(
        evaluate,
        starts,
        lower=problem.unknowns.lower(),
        longest=problem.unknowns.longest(),
        stopping=Stopping(evaluations=iterations, decrement=1e-2),
    )
    values = np.array([decode(parameter.name, number) for number in (*grid, point[index])])
    rise = np.array([*(end.normal.cost - best.cost for end in ends), 0.0])
    order = np.argsort(values)
    return Profile(
        parameter.name,
        parameter.setting,
        values[order],
        rise[order],
        _threshold(parameter, curvature, point[index]),
    )


def _grid(parameter: ParameterEstimate) -> list[float]:
    """Where a quantity is held, as a fit holds it."""
    half = parameter.interval95[1] - parameter.value
    if not np.isfinite(half) or half <= 0:
        values = [parameter.value * factor for factor in FAR]
    else:
        values = [parameter.value + width * half for width in WIDTHS]
    kind = quantity(parameter.name)
    if kind.positive:
        values = [value for value in values if value > 0]
    elif not kind.signed:
        # The grid ends at the bound itself.
        values = sorted({max(value, 0.0) for value in values})
    return [encode(parameter.name, value) for value in values]


def _threshold(parameter: ParameterEstimate, curvature: float, at: float) -> float:
    """The rise of a parabola at the end of the reported interval; 3.84 without one."""
    half = parameter.interval95[1] - parameter.value
    if not np.isfinite(half) or half <= 0:
        return 3.84
    width = encode(parameter.name, parameter.value + half) - at
    return float(max(curvature * width**2, 3.84))


def _without(normal: Normal, index: int) -> Normal:
    """The normal equations with an unknown held."""
    gradient, matrix = normal.gradient.copy(), normal.matrix.copy()
    gradient[index] = 0.0
    matrix[index], matrix[:, index] = 0.0, 0.0
    return Normal(normal.cost, gradient, matrix)
