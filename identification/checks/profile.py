r"""Profile likelihood: how the misfit rises as one quantity is held, the others fitted anew.

An interval from a covariance takes the misfit for a parabola. The profile doesn't: it may
rise on both sides, on one alone or not at all, which is what bounded, one-sided and flat say.
"""

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Campaign
from identification.fit.levenberg_marquardt import Normal, minimise_together
from identification.fit.unknowns.unknowns import decode, encode
from identification.result.estimate import Estimate, solved
from scdpr_jax.robot.parameters import quantity

WIDTHS = (-3.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 3.0)
"""Where a quantity is held, in half widths of its interval."""

FAR = (0.25, 0.5, 0.8, 0.9, 1.1, 1.25, 2.0, 4.0)
"""Where one without an interval is held, as multiples of its value [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Profile:
    """The misfit along one quantity."""

    name: str
    """Name of the quantity."""
    setting: str | None
    """Nominal pretension that it belongs to."""
    values: Float[np.ndarray, " n"]
    """Where it was held, its estimate among them [SI]."""
    rise: Float[np.ndarray, " n"]
    """Rise of the misfit over that of the estimate, the others fitted anew [1]."""
    threshold: float
    """Rise at the end of a 95 % interval, by the robust standard error [1]."""

    @property
    def ends(self) -> tuple[float, float]:
        """Where the misfit passes the threshold on both sides; infinite where it doesn't."""
        at = int(np.argmin(self.rise))
        return self._crossing(range(at, -1, -1), -np.inf), self._crossing(
            range(at, self.values.size), np.inf
        )

    def _crossing(self, way: Sequence[int], never: float) -> float:
        # The root of a parabola's rise is straight: interpolated, it needs few points.
        root = np.sqrt(np.maximum(self.rise, 0.0))
        limit = np.sqrt(self.threshold)
        for before, after in itertools.pairwise(way):
            if root[after] >= limit:
                part = (limit - root[before]) / (root[after] - root[before])
                return float(
                    self.values[before] + part * (self.values[after] - self.values[before])
                )
        return never

    @property
    def label(self) -> str:
        """`bounded`, `one-sided` or `flat`."""
        return ("flat", "one-sided", "bounded")[sum(np.isfinite(self.ends))]


def profiles(
    campaign: Campaign,
    found: Estimate,
    *,
    names: Sequence[str] | None = None,
    iterations: int = 6,
) -> tuple[Profile, ...]:
    """Profiles of the estimated quantities, all points of a profile side by side.

    Args:
        campaign: The campaign that the estimate is of.
        found: The estimate.
        names: Names of the quantities, None for all that were estimated.
        iterations: Most evaluations at a point.

    Returns:
        Their profiles, in the estimate's order.
    """
    chosen = [p for p in found.parameters if p.status != "fixed"]
    problem, point = solved(campaign, found)
    (best,) = problem.evaluate([point])
    return tuple(
        _profile(problem, point, best, parameter, iterations)
        for parameter in chosen
        if names is None or parameter.name in names
    )


def _profile(problem, point, best, parameter, iterations) -> Profile:
    index = problem.unknowns.shared.index((parameter.name, parameter.setting))
    held = _grid(problem, index, parameter)
    open_ones = np.flatnonzero(np.diag(best.matrix) > 0)
    others = open_ones[open_ones != index]
    # Along the valley's floor, as far as the misfit is a parabola.
    across = best.matrix[np.ix_(others, others)]
    along = -np.linalg.lstsq(across, best.matrix[others, index], rcond=None)[0]
    starts = []
    for number in held:
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
        iterations=iterations,
        decrement=1e-2,
    )
    values = np.array([decode(parameter.name, number) for number in (*held, point[index])])
    rise = np.array([*(end.normal.cost - best.cost for end in ends), 0.0])
    order = np.argsort(values)
    return Profile(
        parameter.name,
        parameter.setting,
        values[order],
        rise[order],
        _threshold(parameter, best, index, others, point[index]),
    )


def _grid(problem, index, parameter) -> list[float]:
    half = parameter.interval95[1] - parameter.value
    if not np.isfinite(half) or half <= 0:
        wanted = [parameter.value * factor for factor in FAR]
    else:
        wanted = [parameter.value + width * half for width in WIDTHS]
    known = quantity(parameter.name)
    if known.positive:
        wanted = [value for value in wanted if value > 0]
    elif not known.signed:
        # The grid ends at the bound itself.
        wanted = sorted({max(value, 0.0) for value in wanted})
    return [encode(parameter.name, value) for value in wanted]


def _threshold(parameter, best: Normal, index: int, others: np.ndarray, at: float) -> float:
    """The rise of a parabola at the end of the reported interval; 3.84 without one."""
    half = parameter.interval95[1] - parameter.value
    if not np.isfinite(half) or half <= 0:
        return 3.84
    across = best.matrix[np.ix_(others, others)]
    taken = (
        best.matrix[index, others]
        @ np.linalg.lstsq(across, best.matrix[others, index], rcond=None)[0]
    )
    curvature = best.matrix[index, index] - taken
    width = encode(parameter.name, parameter.value + half) - at
    return float(max(curvature * width**2, 3.84))


def _without(normal: Normal, index: int) -> Normal:
    """The normal equations with an unknown held."""
    gradient, matrix = normal.gradient.copy(), normal.matrix.copy()
    gradient[index] = 0.0
    matrix[index], matrix[:, index] = 0.0, 0.0
    return Normal(normal.cost, gradient, matrix)
