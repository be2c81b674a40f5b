"""Honest standard errors: what is left over is rarely independent noise."""

import dataclasses

import numpy as np
from jaxtyping import Bool, Float
from scipy import special

from scdpr_jax.robot.fields import si
from scdpr_jax.robot.quantities import quantity

STRETCHES = (1, 4, 40)
"""Neighbouring blocks of a run's score that are summed: a block, a tenth, all of it."""

LEVEL = 0.05
"""Chance that the scatter of a sandwich alone makes it count [1]."""

WEAK = 0.1
"""Relative standard error from which a value is called weakly identified [1]."""

NO_INTERVAL = 10.0
"""Relative standard error from which a value that may be zero has no interval [1]: so wide an
interval says nothing of the robot, only of how the model was extrapolated."""

DOES_NOT_FIT = "model_does_not_fit"
"""Status of every quantity of a fit that has failed."""

UNSEEN = 1.0
"""Relative standard error from which a value is called unidentifiable [1]."""


@dataclasses.dataclass(frozen=True)
class ParameterEstimate:
    """A quantity's value with its uncertainty."""

    name: str
    """Name, see `scdpr_jax.robot.quantities.QUANTITIES`."""
    setting: str | None
    """Nominal pretension that the value belongs to, None if it belongs to all."""
    value: float
    """Value [SI]."""
    unit: str
    """SI unit."""
    sigma: float
    """Standard error [SI]; 0 for a fixed value, infinite for one that no run shows."""
    interval95: tuple[float, float]
    """95 % confidence interval [SI]."""
    status: str
    """`identified`, `weak`, `unidentifiable`, `at_bound`, `fixed` or `model_does_not_fit`."""
    degrees_of_freedom: float = dataclasses.field(default=np.inf, metadata=si("1"))
    """Degrees of freedom of the standard error [1]."""

    @property
    def label(self) -> str:
        """Name and setting: "effective_pretension 350 N"."""
        return self.name if self.setting is None else f"{self.name} {self.setting}"

    def interval(self, confidence: float) -> tuple[float, float]:
        """The confidence interval of another level.

        Args:
            confidence: Level, 0.95 for 95 % [1].

        Returns:
            Its ends [SI].
        """
        half = half_width(self.sigma, confidence, self.degrees_of_freedom)
        return self.value - half, self.value + half

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval before it is cut where the quantity ends [SI]."""
        return half_width(self.sigma, 0.95, self.degrees_of_freedom)

    @property
    def may_be_zero(self) -> bool:
        """Whether the 95 % interval, before it is cut, holds zero."""
        return self.half_width >= abs(self.value)

    @property
    def relative(self) -> float:
        """The same over the value, or over what is negligible of the quantity [1]."""
        size = magnitude(self.name, self.value)
        return self.half_width / size if size else np.inf

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.label} = {self.value:.5g}{unit} ± {self.sigma:.2g}{unit}, {self.status}"


def half_width(sigma: float, confidence: float, degrees_of_freedom: float) -> float:
    """Half of a confidence interval by Student's distribution.

    Args:
        sigma: Standard error.
        confidence: Level [1].
        degrees_of_freedom: Degrees of freedom of the standard error [1].

    Returns:
        Half of the interval, in the standard error's unit.
    """
    if not np.isfinite(sigma):
        return np.inf
    return float(special.stdtrit(degrees_of_freedom, 0.5 + confidence / 2) * sigma)


def interval95(
    name: str, value: float, sigma: float, degrees_of_freedom: float
) -> tuple[float, float]:
    """A quantity's 95 % interval, cut where the quantity itself ends.

    Args:
        name: Name of the quantity.
        value: Its value [SI].
        sigma: Its standard error [SI].
        degrees_of_freedom: Degrees of freedom of that [1].

    Returns:
        Its ends [SI]; of what can't be negative none is, unless nothing is known.
    """
    half = half_width(sigma, 0.95, degrees_of_freedom)
    unbounded = quantity(name).signed or not np.isfinite(half)
    return value - half if unbounded else max(value - half, 0.0), value + half


@dataclasses.dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of a fit's unknowns."""

    sigma: Float[np.ndarray, " n"]
    """Standard errors; infinite for what no run shows."""
    correlation: Float[np.ndarray, "n n"]
    """Correlation by the Gauss-Newton matrix; 0 with what no run shows."""
    degrees_of_freedom: Float[np.ndarray, " n"]
    """Degrees of freedom of the standard errors; infinite where the noise alone gives them."""


def covariance(
    matrix: Float[np.ndarray, "n n"],
    scores: Float[np.ndarray, "runs blocks n"],
    seen: Bool[np.ndarray, " n"],
    *,
    otherwise: Float[np.ndarray, "n n"] | float = 0.0,
) -> Covariance:
    r"""Standard errors that hold for residuals that are correlated in time.

    Noise of the stated size that is independent from sample to sample gives
    $(J^TJ)^{-1}$. An unmodelled force may act for seconds, and a rounding error of an
    encoder lasts as long as its drive stands still: then neighbouring residuals aren't
    independent. The sandwich

    $$ C = (J^TJ)^{-1} \Big( \sum_g s_g s_g^T \Big) (J^TJ)^{-1} $$

    takes the scores $s_g$ of whole stretches $g$ of a run together. A short stretch
    misses slow correlation, a long one leaves few stretches to average over, whose spread
    is itself uncertain: a sandwich counts where it exceeds the noise's answer by more than
    its own scatter allows, and then the widest of those that do, with Student's
    distribution of as many degrees of freedom as it has stretches, less one.

    Reference: A. C. Cameron, D. L. Miller, "A practitioner's guide to cluster-robust
    inference", J. Human Resources 50(2), 2015, doi:10.3368/jhr.50.2.317.

    Args:
        matrix: Weighted $J^TJ$.
        scores: Parts of the weighted $J^Tr$ from equal stretches of each run.
        seen: The unknowns that the data say something about.
        otherwise: The part of the matrix that no run's scores belong to, whose errors are
            taken to be as they were stated.

    Returns:
        Standard errors and correlation of all unknowns.
    """
    at = np.flatnonzero(seen)
    scale = 1 / np.sqrt(np.diag(matrix)[at])
    scaled = matrix[np.ix_(at, at)] * np.outer(scale, scale)
    inverse = np.linalg.pinv(scaled, hermitian=True)
    white = np.diag(inverse)
    given = np.broadcast_to(otherwise, matrix.shape)[np.ix_(at, at)] * np.outer(scale, scale)
    stated = np.diag(inverse @ given @ inverse)
    variance, freedom = white.copy(), np.full(at.size, np.inf)
    for length in STRETCHES:
        runs, blocks, size = scores.shape
        grouped = scores.reshape(runs * blocks // length, length, size).sum(axis=1)
        pulls = (grouped[:, at] * scale) @ inverse
        groups = np.count_nonzero(np.any(grouped != 0, axis=1))
        if groups < 2:
            continue
        spread = np.sum(np.square(pulls), axis=0) * groups / (groups - 1)
        clustered = spread + stated
        scatter = special.chdtri(groups - 1, LEVEL) / (groups - 1)
        wider = _width(clustered, groups - 1.0) > _width(variance, freedom)
        taken = (spread > scatter * (white - stated)) & wider
        variance = np.where(taken, clustered, variance)
        freedom = np.where(taken, groups - 1.0, freedom)
    sigma, degrees = np.full(seen.size, np.inf), np.full(seen.size, np.inf)
    sigma[at], degrees[at] = scale * np.sqrt(variance), freedom
    correlation = np.eye(seen.size)
    spread = np.sqrt(white)
    correlation[np.ix_(at, at)] = inverse / np.outer(spread, spread)
    return Covariance(sigma, correlation, degrees)


def _width(
    variance: Float[np.ndarray, " n"], freedom: Float[np.ndarray, " n"] | float
) -> Float[np.ndarray, " n"]:
    """Half widths of 95 % intervals."""
    return np.sqrt(variance) * special.stdtrit(freedom, 0.975)


def is_undetermined(name: str, number: float, sigma: float) -> bool:
    """Whether the data say so little of a quantity that no interval is given.

    Args:
        name: Name of the quantity.
        number: Its value [SI].
        sigma: Its standard error as a fit holds it: relative for what must be positive,
            which from `UNSEEN` on isn't known within a factor of three either way.

    Returns:
        Whether it is so.
    """
    if quantity(name).positive:
        return sigma >= UNSEEN
    return not np.isfinite(sigma) or sigma >= NO_INTERVAL * abs(number) > 0


USUAL = {
    "friction_coefficient": 0.01,
    "upper_friction_coefficient": 0.01,
    "drive_friction": 0.05,
    "drive_friction_difference": 0.05,
    "loop_stiffness": 100.0,
    "lower_carriage_damping": 1.0,
    "upper_carriage_damping": 1.0,
    "static_friction_surplus": 0.01,
}
"""Usual sizes of quantities that may be zero [SI]."""

NEGLIGIBLE = 0.1
"""Share of its usual size below which a quantity may as well be zero [1]."""


def magnitude(name: str, number: float) -> float:
    """What errors and changes of a quantity are measured by.

    Args:
        name: Its name.
        number: Its value [SI].

    Returns:
        The value's own size, or what is negligible of such a quantity where that is more.
    """
    return max(abs(number), NEGLIGIBLE * USUAL.get(name, 0.0))


def judge(name: str, value: float, sigma: float, *, at_bound: bool) -> str:
    """What a value and its standard error are worth, in one word.

    Args:
        name: Name of the quantity.
        value: The value.
        sigma: Its standard error, in the same unit.
        at_bound: Whether the fit was stopped by the value's bound.

    Returns:
        `at_bound`, `unidentifiable`, `weak` or `identified`.
    """
    if at_bound:
        return "at_bound"
    size = magnitude(name, value)
    relative = sigma / size if size != 0 else np.inf
    if relative >= UNSEEN:
        return "unidentifiable"
    return "weak" if relative >= WEAK else "identified"
