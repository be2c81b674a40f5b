"""Parameters of a robot from a campaign of logged runs, all runs at once.

A fit goes from coarse to fine: the scan's valleys are followed down on a few runs, the best of
them with all runs on the coarser grid, and its end is put right by deferred correction. What a
run that is held out says is asked last, of its circumstances alone. Every run at once and a
single descent would be simpler, and end in the wrong valley of the vibration's phase.
"""

import concurrent.futures
import dataclasses
from collections.abc import Mapping, Sequence

import jax
import numpy as np
from jaxtyping import Float

from identification.campaign.types import Campaign
from identification.data.circumstances import NAMES, Circumstances
from identification.fit.comparison import comparisons
from identification.fit.correction import corrected
from identification.fit.problem import Problem
from identification.fit.run_sums import RunSums
from identification.fit.starts import Valley, starts
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import FOLLOWS, encode
from identification.judge.identifiability import identifiability, motion_over_noise
from identification.judge.influence import influence, run_normal
from identification.judge.verdict import is_doubtful, judged, unexplained
from identification.result.compliance import with_compliance
from identification.result.estimate import Estimate, Fit
from identification.result.fitted_robot import Residual, fitted_robot
from scdpr_jax.numerics.levenberg_marquardt import Minimum, settled
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from scdpr_jax.robot.quantities import value
from scdpr_jax.robot.state import LOWER

CORRECTIONS = 3
"""How often the coarser grid's own error is taken off, see `identification.fit.correction`: it
hardly depends on the point, and the third time tells ten digits, at the price of an evaluation.
"""


def estimate(
    campaign: Campaign, options: FitOptions | None = None, *, progress: Progress | bool = SILENT
) -> Estimate:
    """Parameters from all runs of a campaign, by Levenberg-Marquardt on exact friction.

    Start poses, the forces of knocks and unknown clocks are estimated with them. Several
    starts, the valleys of a scan over pretension and friction, are followed down on a few
    runs; the best of them goes on with all.

    Args:
        campaign: The campaign.
        options: What the fit is asked for; None for what suits most campaigns.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The estimate.

    Raises:
        ValueError: If float64 is off, if a name is unknown, if a run can't be used, or if
            something was measured at a setting that no run has.
        FloatingPointError: If a run's simulation isn't finite at the solution.
    """
    progress = listening(progress)
    require_float64()
    problem = Problem.of(campaign, options or FitOptions())
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # Compiling leaves the interpreter free: the rest comes along meanwhile.
        aside.submit(problem.compile)
        begun = starts(problem, progress.part(0.0, 0.3))
    rest = progress.part(0.3, 1.0)
    found = solve(problem, begun.points, valleys=begun.valleys, progress=rest)
    return with_compliance(found, campaign)


def solve(
    problem: Problem,
    points: Sequence[Float[np.ndarray, " n"]],
    *,
    valleys: tuple[Valley, ...] = (),
    progress: Progress = SILENT,
) -> Estimate:
    """The estimate that some starts lead to.

    Args:
        problem: The problem.
        points: Vectors of the fit to begin at.
        valleys: The minima of the scan that they come from.
        progress: Told what is being done and which share of it is done.

    Returns:
        The estimate.

    Raises:
        FloatingPointError: If a run's simulation isn't finite at the solution.
    """
    ends = []
    for number, start in enumerate(points):
        begin, end = (0.6 * each / len(points) for each in (number, number + 1))
        inner = progress.part(begin, end, f"start {number + 1} of {len(points)}")
        ends.append(problem.minimise(start, iterations=15, decrement=1.0, progress=inner))
    if not ends:
        raise FloatingPointError(
            "no robot explains these runs: no start of the fit has a finite simulation. A "
            "wrong unit, sign or plug does that: see `scdpr check`."
        )
    point, done = min(ends, key=lambda end: end.normal.cost).point, 0
    for number in range(CORRECTIONS):
        progress("all runs at the logs' own rate", 0.6 + 0.1 * number)
        problem = corrected(problem, point)
        found = problem.minimise(point, iterations=20, decrement=1e-2)
        minimum = settled(found, problem.unknowns.lower(), problem.unknowns.longest())
        point, done = minimum.point, done + minimum.iterations
    if problem.held_out:
        progress("runs held out", 0.9)
        point = problem.minimise(point, iterations=12, decrement=1e-2, held_out=True).point
    progress("standard errors", 1.0)
    count = problem.measurements()
    fit = Fit(
        starts=tuple(end.normal.cost / count for end in ends),
        valleys=valleys,
        iterations=done,
        ended=minimum.ended,
        misfit=minimum.normal.cost / count,
        measurements=count,
    )
    return _estimate(problem, minimum, point, fit)


def _seen(problem: Problem) -> float:
    """How far off a camera has the lower carriage, the worst of all runs' [m]."""
    sensors, runs = problem.logs.sensors, problem.logs.runs
    own = [float(sensors.of_camera(run)[LOWER]) for run in runs if run.camera is not None]
    return max(own, default=sensors.camera_position_sigma)


def _estimate(
    problem: Problem, minimum: Minimum, point: Float[np.ndarray, " n"], fit: Fit
) -> Estimate:
    """What a minimum says, and the point beside it at which the runs held out are predicted."""
    (sums,) = problem.sums([minimum.point])
    _require_finite(problem, sums)
    runs, accepted = comparisons(problem, point), problem.logs.accepted
    radius = float(value(problem.prior, "effective_radius"))
    seen = _seen(problem) / radius
    failing = unexplained(runs, contradicted=bool(accepted), seen=seen)
    by_errors = fitted_robot(problem, minimum, sums)
    nameplate = float(value(problem.prior, "drive_inertia"))
    doubtful = is_doubtful(by_errors.parameters, runs, nameplate=nameplate)
    telling = identifiability(problem, minimum.point, sums, motion=motion_over_noise(runs))
    fitted = dataclasses.replace(
        by_errors,
        parameters=judged(
            by_errors.parameters,
            failed=bool(failing),
            contradicted=bool(accepted) or doubtful,
            open_by_rank=telling.open_by_rank,
            left_open=telling.left_open(),
        ),
        residuals=tuple(
            Residual(channel.name, channel.rms, channel.sigma, channel.is_noise)
            for run in runs
            for channel in run.channels
        ),
    )
    opened = np.flatnonzero(problem.unknowns.opened)
    free = dict.fromkeys(name for name, _ in problem.unknowns.opened_names)
    return Estimate(
        fitted=fitted,
        circumstances=_circumstances(problem, point),
        comparisons=runs,
        fit=fit,
        identifiability=telling,
        influence=influence(
            run_normal(problem, minimum.point, sums),
            by_errors.estimated,
            encoded=minimum.point[opened],
        ),
        unexplained=failing,
        accepted=accepted,
        options=dataclasses.replace(problem.options, free=tuple(free)),
    )


def _require_finite(problem: Problem, sums: Mapping[int, RunSums]) -> None:
    """Refuse values at which what a run says of them isn't finite: nothing can be judged."""
    runs = problem.logs.runs
    broken = [
        runs[run].name for run, of_run in sums.items() if not np.all(np.isfinite(of_run.matrix))
    ]
    if broken:
        raise FloatingPointError(
            f"no robot explains {', '.join(broken)}: the fit was driven to values at which the "
            "simulation overflows. A wrong unit, sign or plug does that: see `scdpr check`, "
            "or leave the run out."
        )


def vector(problem: Problem, estimate: Estimate) -> Float[np.ndarray, " n"]:
    """An estimate as a vector of a problem of the same runs.

    Args:
        problem: The problem; it may free more quantities than the estimate did.
        estimate: The estimate.

    Returns:
        Vector of the fit.
    """
    point, unknowns = problem.at_rest(), problem.unknowns
    estimated = {(p.name, p.setting): p.value for p in estimate.parameters}
    for index, (name, setting) in enumerate(unknowns.shared):
        leader = (FOLLOWS.get(name, name), setting)
        number = estimated.get((name, setting), estimated.get(leader))
        if number is not None:
            point[index] = encode(name, number)
    logs = problem.logs
    for run, clock in zip(logs.cabled, logs.clocks, strict=True):
        circumstances = estimate.circumstances[logs.runs[run].name]
        point[unknowns.circumstances(run)] = circumstances.vector
        # The fit holds what is beyond what was known of the clock before.
        point[unknowns.circumstance(run, "clock_offset")] -= clock.offset
    for run in _turning(problem):
        circumstances = estimate.circumstances[logs.runs[run].name]
        point[unknowns.circumstances(run)] = circumstances.vector
    return point


def solved(campaign: Campaign, estimate: Estimate) -> tuple[Problem, Float[np.ndarray, " n"]]:
    """The problem that an estimate solved, and where.

    Args:
        campaign: The campaign that the estimate is of.
        estimate: The estimate.

    Returns:
        The problem, corrected about the estimate, and the estimate as its vector.
    """
    options = dataclasses.replace(estimate.options, robot=estimate.robot)
    problem = Problem.of(campaign, options)
    point = vector(problem, estimate)
    return corrected(problem, point), point


def _circumstances(
    problem: Problem, point: Float[np.ndarray, " n"]
) -> dict[str, Circumstances]:
    """What was estimated of each run; clocks with what was known of them before."""
    logs, estimated = problem.logs, {}
    for run, clock in zip(logs.cabled, logs.clocks, strict=True):
        vector = point[problem.unknowns.circumstances(run)]
        vector[NAMES.index("clock_offset")] += clock.offset
        estimated[logs.runs[run].name] = Circumstances.of(vector)
    for run in _turning(problem):
        vector = point[problem.unknowns.circumstances(run)]
        estimated[logs.runs[run].name] = Circumstances.of(vector)
    return estimated


def _turning(problem: Problem) -> list[int]:
    """The runs of bare drives that turn from the first."""
    return [run for run in problem.logs.motors if problem.logs.runs[run].in_motion]


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
