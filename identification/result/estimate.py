"""Parameters of a robot from a campaign of logged runs, all runs at once."""

import concurrent.futures
import dataclasses
from collections.abc import Callable, Mapping, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from identification.campaign.types import Campaign
from identification.fit.accumulate import RunSums, assemble
from identification.fit.comparison import Comparison, compare, compare_motors
from identification.fit.levenberg_marquardt import Minimum, free_unknowns
from identification.fit.problem import Problem
from identification.fit.residuals import Circumstances
from identification.fit.starts import Valley, starts
from identification.fit.unknowns.measured import Measured
from identification.fit.unknowns.models import Model
from identification.fit.unknowns.unknowns import (
    CIRCUMSTANCES,
    CLOCK,
    DEFAULT_FREE,
    FOLLOWS,
    PER_SETTING,
    Unknowns,
    decode,
    encode,
)
from identification.judge.identifiability import Identifiability, identifiability
from identification.judge.influence import Influence, influence, run_normal
from identification.judge.uncertainty import (
    ParameterEstimate,
    covariance,
    half_width,
    is_untold,
    judge,
)
from scdpr_jax.robot.parameters import QUANTITIES, Robot, exact, quantity, replace, value
from scdpr_jax.robot.prototype import consistent

CORRECTIONS = 2
"""How often the coarser grid's own error is taken off, see `Problem.corrected`."""

Progress = Callable[[str, float], None]
"""Told what is being done and which share of it is done, 0 to 1."""


@dataclasses.dataclass(frozen=True)
class Fit:
    """How an estimate came about."""

    starts: tuple[float, ...]
    """Misfit per measurement that each start ended at, before the last iterations [1]."""
    valleys: tuple[Valley, ...]
    """Every distinct minimum that was found on the way, with its misfit."""
    iterations: int
    """Evaluations of the normal equations after the best start was chosen."""
    ended: str
    """How the last fit ended: `converged`, `stalled` at a kink, or `unfinished`."""
    misfit: float
    """Misfit per measurement, see `identification.fit.misfit`; 1 if it is only noise [1]."""
    measurements: float
    """Number of independent measurements, see `identification.data.record.readings`."""


@dataclasses.dataclass(frozen=True, eq=False)
class Estimate:
    """What a campaign says about a robot."""

    robot: Robot
    """The robot with the estimated values, the pretension being the first setting's."""
    parameters: tuple[ParameterEstimate, ...]
    """Every named quantity, estimated or fixed."""
    correlation: Float[np.ndarray, "n n"]
    """Correlation of the estimated ones, in their order."""
    circumstances: dict[str, Circumstances]
    """What was estimated of each run by itself, by the run's name."""
    comparisons: tuple[Comparison, ...]
    """Every run beside its simulation, those that were held out included."""
    fit: Fit
    """How it came about."""
    identifiability: Identifiability
    """What these logs can tell of what."""
    influence: Influence
    """Which run moves which quantity, and the bootstrap over runs."""
    measured: tuple[Measured, ...] = ()
    """What was measured otherwise."""
    clock_drifts: bool = False
    """Whether the cameras' clocks may drift."""
    models: tuple[Model, ...] = ()
    """The models that were compared, the usual one first; empty where that is enough."""
    choice: int = 0
    """Which of them this estimate is of."""

    @property
    def lacks(self) -> tuple[str, ...]:
        """What the usual model lacks, by the choice between models."""
        return self.models[self.choice].added if self.models else ()

    def of_setting(self, label: str) -> Robot:
        """The robot at a nominal pretension.

        Args:
            label: The setting as the logs name it, "350 N".

        Returns:
            The robot with that setting's effective pretension.

        Raises:
            ValueError: If no fitted run had that setting.
        """
        for parameter in self.parameters:
            if parameter.name == PER_SETTING and parameter.setting in (label, None):
                return replace(self.robot, {PER_SETTING: parameter.value})
        known = sorted(str(p.setting) for p in self.parameters if p.name == PER_SETTING)
        raise ValueError(
            f"no effective pretension for the setting {label!r}, got runs at "
            f"{', '.join(known)} only. Fit a run of that setting too."
        )


def estimate(
    campaign: Campaign,
    *,
    robot: Robot | None = None,
    free: Sequence[str] = DEFAULT_FREE,
    hold_out: Sequence[str] = (),
    measured: Sequence[Measured] = (),
    clock_drifts: bool = False,
    progress: Progress = lambda doing, share: None,
) -> Estimate:
    """Parameters from all runs of a campaign, by Levenberg-Marquardt on exact friction.

    Start poses, the forces of knocks and unknown clocks are estimated with them. Several
    starts, the valleys of a scan over pretension and friction, are followed down on a few
    runs; the best of them goes on with all.

    Args:
        campaign: The campaign.
        robot: What isn't estimated, and where the search for the rest begins; default:
            the consistent prototype with what the campaign says of the rig.
        free: Names of the quantities to estimate. Each nominal pretension has its own
            effective one.
        hold_out: Names of runs that say nothing about the shared quantities; their own
            circumstances are estimated once these are known, to predict them.
        measured: What was measured otherwise: it counts as a measurement of its own, and
            a quantity that was is free.
        clock_drifts: Whether the cameras' clocks may drift: a rate for each run is then
            estimated with its offset.
        progress: Told what is being done and which share of it is done.

    Returns:
        The estimate.

    Raises:
        ValueError: If float64 is off, if a name is unknown, if a run can't be used, or if
            something was measured at a setting that no run has.
        FloatingPointError: If a run's simulation isn't finite at the solution.
    """
    require_float64()
    prior = exact(replace(robot or consistent(), campaign.robot))
    problem = Problem.of(
        campaign,
        prior,
        free,
        frozenset(hold_out),
        measured=measured,
        clock_drifts=clock_drifts,
    )
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # Compiling leaves the interpreter free: the rest comes along meanwhile.
        aside.submit(problem.compile)
        begun = starts(problem, lambda doing, share: progress(doing, 0.3 * share))
    return solve(
        problem,
        begun.points,
        campaign=campaign,
        valleys=begun.valleys,
        progress=lambda doing, share: progress(doing, 0.3 + 0.7 * share),
    )


def solve(
    problem: Problem,
    points: Sequence[Float[np.ndarray, " n"]],
    *,
    campaign: Campaign,
    valleys: tuple[Valley, ...] = (),
    progress: Progress = lambda doing, share: None,
) -> Estimate:
    """The estimate that some starts lead to.

    Args:
        problem: The problem.
        points: Vectors of the fit to begin at.
        campaign: The campaign that the problem is of.
        valleys: What else was found on the way.
        progress: Told what is being done and which share of it is done.

    Returns:
        The estimate.

    Raises:
        FloatingPointError: If a run's simulation isn't finite at the solution.
    """
    ends = []
    for number, start in enumerate(points):
        told = _told(progress, f"start {number + 1} of {len(points)}", 0.0, 0.6)
        ends.append(problem.minimise(start, iterations=15, decrement=1.0, report=told))
    point, done = min(ends, key=lambda end: end.normal.cost).point, 0
    for number in range(CORRECTIONS):
        # What the coarser grid errs by hardly depends on the point: twice is enough.
        progress("all runs at the logs' own rate", 0.6 + 0.15 * number)
        problem = problem.corrected(point)
        minimum = problem.minimise(point, iterations=20, decrement=1e-2)
        point, done = minimum.point, done + minimum.iterations
    if problem.held_out:
        progress("runs held out", 0.9)
        point = problem.minimise(point, iterations=12, decrement=1e-2, held_out=True).point
    progress("standard errors", 1.0)
    costs = tuple(end.normal.cost / problem.measurements() for end in ends)
    (sums,) = problem.each([minimum.point])
    judged = _judged(problem, minimum, sums)
    return Estimate(
        **judged,
        circumstances=_circumstances(problem, point),
        comparisons=_comparisons(problem, point, campaign),
        fit=Fit(
            starts=costs,
            valleys=valleys,
            iterations=done,
            ended=minimum.ended,
            misfit=minimum.normal.cost / problem.measurements(),
            measurements=problem.measurements(),
        ),
        measured=problem.measured,
        clock_drifts=problem.clock_drifts,
        identifiability=identifiability(problem, minimum.point, sums),
        influence=influence(
            run_normal(problem, minimum.point, sums),
            [p for p in judged["parameters"] if p.status != "fixed"],
            held=minimum.point[np.flatnonzero(problem.unknowns.opened)],
        ),
    )


def vector(problem: Problem, found: Estimate) -> Float[np.ndarray, " n"]:
    """An estimate as a vector of a problem of the same runs.

    Args:
        problem: The problem; it may free more quantities than the estimate did.
        found: The estimate.

    Returns:
        Vector of the fit.
    """
    point = problem.at_rest()
    estimated = {(p.name, p.setting): p.value for p in found.parameters}
    for index, (name, setting) in enumerate(problem.unknowns.shared):
        leader = (FOLLOWS.get(name, name), setting)
        number = estimated.get((name, setting), estimated.get(leader))
        if number is not None:
            point[index] = encode(name, number)
    for row, run in enumerate(problem.cabled):
        own = found.circumstances[problem.runs[run].name]
        at = problem.own(run)
        point[at] = [float(getattr(own, name)) for name in CIRCUMSTANCES]
        # The fit holds what is beyond what was known of the clock before.
        point[at[CIRCUMSTANCES.index("clock_offset")]] -= problem.clocks[row].offset
    return point


def solved(campaign: Campaign, found: Estimate) -> tuple[Problem, Float[np.ndarray, " n"]]:
    """The problem that an estimate solved, and where.

    Args:
        campaign: The campaign that the estimate is of.
        found: The estimate.

    Returns:
        The problem, corrected about the estimate, and the estimate as its vector.
    """
    problem = Problem.of(
        campaign,
        found.robot,
        tuple(dict.fromkeys(p.name for p in found.parameters if p.status != "fixed")),
        frozenset(run.name for run in found.comparisons if run.held_out),
        measured=found.measured,
        clock_drifts=found.clock_drifts,
    )
    point = vector(problem, found)
    return problem.corrected(point), point


def _told(
    progress: Progress, doing: str, begun: float, share: float
) -> Callable[[int, float], None]:
    """Progress of a minimisation, which halves what is left every five evaluations."""
    return lambda done, cost: progress(doing, begun + share * (1 - 0.5 ** (done / 5)))


def _judged(
    problem: Problem, minimum: Minimum, sums: Mapping[int, RunSums]
) -> dict[str, object]:
    """Robot, parameters and their correlation, from where the fit ended."""
    unknowns, point, lower = problem.unknowns, minimum.point, problem.unknowns.lower()
    _, scores = assemble(unknowns, sums, shared=True)
    chosen = np.flatnonzero(unknowns.opened)
    seen = free_unknowns(minimum.normal, point, lower)
    otherwise = problem.otherwise(point).matrix
    found = covariance(minimum.normal.matrix, scores, seen, otherwise=otherwise)
    parameters = []
    for index in np.flatnonzero(unknowns.opened):
        name, setting = unknowns.shared[index]
        known, sigma = quantity(name), float(found.sigma[index])
        freedom = float(found.degrees_of_freedom[index])
        number = decode(name, point[index])
        at_bound = bool(point[index] <= lower[index])
        if is_untold(name, number, sigma) and not at_bound:
            # What no run shows is what it was taken to be, not where a search left it.
            number, sigma = float(value(problem.prior, name)), np.inf
        # The logarithm's standard error is relative.
        sigma *= number if known.positive else 1.0
        half = half_width(sigma, 0.95, freedom)
        low = (
            number - half if known.signed or not np.isfinite(half) else max(number - half, 0.0)
        )
        parameters.append(
            ParameterEstimate(
                name=name,
                setting=setting,
                value=number,
                unit=known.unit,
                sigma=sigma,
                interval95=(low, number + half),
                status=judge(name, number, sigma, at_bound=at_bound),
                degrees_of_freedom=freedom,
            )
        )
    robot = replace(problem.prior, {p.name: p.value for p in reversed(parameters)})
    return {
        "robot": robot,
        "parameters": (*parameters, *_fixed(robot, unknowns)),
        "correlation": found.correlation[np.ix_(chosen, chosen)],
    }


def _fixed(robot: Robot, unknowns: Unknowns) -> list[ParameterEstimate]:
    opened = {unknowns.shared[index][0] for index in np.flatnonzero(unknowns.opened)}
    fixed = []
    for known in QUANTITIES:
        if known.name not in opened:
            number = float(value(robot, known.name))
            fixed.append(
                ParameterEstimate(
                    name=known.name,
                    setting=None,
                    value=number,
                    unit=known.unit,
                    sigma=0.0,
                    interval95=(number, number),
                    status="fixed",
                )
            )
    return fixed


def _circumstances(
    problem: Problem, point: Float[np.ndarray, " n"]
) -> dict[str, Circumstances]:
    """What was estimated of each run; clocks with what was known of them before."""
    found = {}
    for run, known in zip(problem.cabled, problem.clocks, strict=True):
        *moving, clock, drift = map(float, point[problem.own(run)])
        found[problem.runs[run].name] = Circumstances(*moving, clock + known.offset, drift)
    return found


def _comparisons(
    problem: Problem, point: Float[np.ndarray, " n"], campaign: Campaign
) -> tuple[Comparison, ...]:
    """Every run beside its simulation, in the campaign's order."""
    unknowns = problem.unknowns
    common = {
        "sensors": campaign.sensors,
        "held_out": frozenset(problem.runs[i].name for i in problem.held_out),
    }
    found: list[Comparison] = []
    if problem.records is not None:
        predicted, clocks = problem.predictions(point), problem.vectors(point)[:, -CLOCK:]
        runs = tuple(problem.runs[i] for i in problem.cabled)
        found += compare(predicted, clocks, problem.records, runs=runs, **common)
    if problem.motor_records is not None:
        own = jnp.asarray(np.stack([point[unknowns.local[i]] for i in problem.motors]))
        runs = tuple(problem.runs[i] for i in problem.motors)
        found += compare_motors(
            problem.prior, unknowns.free, own, problem.motor_records, runs=runs, **common
        )
    order = {run.name: number for number, run in enumerate(problem.runs)}
    return tuple(sorted(found, key=lambda comparison: order[comparison.name]))


def require_float64() -> None:
    """Refuse to fit in single precision.

    Raises:
        ValueError: If float64 is off.
    """
    if not jax.config.jax_enable_x64:
        raise ValueError(
            "`estimate` needs float64, got float32: rounding would hide what the encoders "
            'resolve. Call `jax.config.update("jax_enable_x64", True)` first.'
        )
