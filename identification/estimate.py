"""Parameters of a robot from a campaign of logged runs, all runs at once."""

import concurrent.futures
import dataclasses
from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from identification.accumulate import MotorRecord, assemble, motor_sums, run_sums
from identification.campaign.types import Campaign, Run
from identification.comparison import Comparison, compare, compare_motors
from identification.first_guess import (
    FRICTION_FORCES,
    KNOCKS,
    PRETENSIONS,
    scan,
)
from identification.levenberg_marquardt import Minimum, Normal, free_unknowns, minimise
from identification.record import Record, coarse, motor_record, stacked
from identification.residuals import Circumstances
from identification.start import Clock, clocks
from identification.uncertainty import ParameterEstimate, covariance, half_width, judge
from identification.unknowns import (
    DEFAULT_FREE,
    PER_SETTING,
    Unknowns,
    decode,
    encode,
    layout,
    start_values,
)
from scdpr_jax.parameters import QUANTITIES, Robot, exact, quantity, replace, value
from scdpr_jax.prototype import consistent

COARSE_STEP = 5e-3
"""Step of the scan and of the first iterations [s]: some 20 µm of error at it."""

SCAN_STEP = 1e-2
"""Step of the scan [s]: a tenth of the fastest vibration that it has to follow."""

SCAN_RUNS = 2
"""Runs of a setting that the scan looks at: those that move the furthest sideways."""

STARTS = 3
"""Valleys of the scan that a fit is begun in."""

Progress = Callable[[str, float], None]
"""Told what is being done and which share of it is done, 0 to 1."""


@dataclasses.dataclass(frozen=True)
class Fit:
    """How an estimate came about."""

    starts: tuple[float, ...]
    """Misfit per measurement that each start ended at, on the coarse grid [1]."""
    iterations: int
    """Evaluations of the normal equations on the log's own grid."""
    ended: str
    """How the last fit ended: `converged`, `stalled` at a kink, or `unfinished`."""
    misfit: float
    """Misfit per measurement, see `identification.misfit`; 1 if it is only noise [1]."""
    measurements: int
    """Number of measurements."""


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
    progress: Progress = lambda doing, share: None,
) -> Estimate:
    """Parameters from all runs of a campaign, by Levenberg-Marquardt on exact friction.

    Start poses, the forces of knocks and unknown clocks are estimated with them. Several
    starts, the best valleys of a scan over pretension and friction, are fitted on a
    coarse grid; the best of them on the logs' own.

    Args:
        campaign: The campaign.
        robot: What isn't estimated, and where the search for the rest begins; default:
            the consistent prototype with what the campaign says of the rig.
        free: Names of the quantities to estimate. Each nominal pretension has its own
            effective one.
        hold_out: Names of runs that say nothing about the shared quantities; their own
            circumstances are estimated once these are known, to predict them.
        progress: Told what is being done and which share of it is done.

    Returns:
        The estimate.

    Raises:
        ValueError: If float64 is off, if a name is unknown, or if a run can't be used.
        FloatingPointError: If a run's simulation isn't finite at the solution.
    """
    _require_float64()
    prior = exact(replace(robot or consistent(), campaign.robot))
    problem = _Problem.of(campaign, prior, tuple(free), frozenset(hold_out))
    rough = problem.on_grid(COARSE_STEP)
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # Compiling leaves the interpreter free: both grids' functions come along meanwhile.
        for each in (rough, problem):
            aside.submit(each.evaluate, problem.at_rest())
        progress("first guesses", 0.0)
        starts = _starts(problem, progress)
    ends = []
    for number, start in enumerate(starts):
        share = 0.5 / len(starts)
        told = _told(
            progress, f"start {number + 1} of {len(starts)}", 0.1 + share * number, share
        )
        ends.append(rough.minimise(start, iterations=15, decrement=1.0, report=told))
    best = min(ends, key=lambda end: end.normal.cost)
    told = _told(progress, "all runs at the logs' own rate", 0.6, 0.35)
    minimum = problem.minimise(best.point, iterations=25, decrement=1e-2, report=told)
    point = minimum.point
    if problem.held_out:
        progress("runs held out", 0.95)
        alone = problem.minimise(point, iterations=12, decrement=1e-2, held_out=True)
        point = alone.point
    progress("standard errors", 1.0)
    costs = tuple(end.normal.cost / rough.measurements() for end in ends)
    return Estimate(
        **_judged(problem, minimum),
        circumstances=_circumstances(problem, point),
        comparisons=_comparisons(problem, point, campaign),
        fit=Fit(
            starts=costs,
            iterations=minimum.iterations,
            ended=minimum.ended,
            misfit=minimum.normal.cost / problem.measurements(),
            measurements=problem.measurements(),
        ),
    )


def _told(
    progress: Progress, doing: str, begun: float, share: float
) -> Callable[[int, float], None]:
    """Progress of a minimisation, which halves what is left every five evaluations."""
    return lambda done, cost: progress(doing, begun + share * (1 - 0.5 ** (done / 5)))


@dataclasses.dataclass(frozen=True, eq=False)
class _Problem:
    """A campaign prepared for fitting."""

    runs: tuple[Run, ...]
    prior: Robot
    unknowns: Unknowns
    held_out: frozenset[int]
    cabled: tuple[int, ...]
    clocks: tuple[Clock, ...]
    records: Record | None
    motors: tuple[int, ...]
    motor_records: MotorRecord | None

    @classmethod
    def of(
        cls, campaign: Campaign, prior: Robot, free: tuple[str, ...], hold_out: frozenset[str]
    ) -> "_Problem":
        runs, sensors = campaign.runs, campaign.sensors
        held_out = frozenset(runs.index(campaign.run(name)) for name in hold_out)
        motors = tuple(i for i, run in enumerate(runs) if run.kind == "motor_step")
        cabled = tuple(i for i in range(len(runs)) if i not in motors)
        radius = float(value(prior, "effective_radius"))
        known = clocks([runs[i] for i in cabled], sensors, radius)
        height = float(value(prior, "frame_height"))
        return cls(
            runs=runs,
            prior=prior,
            unknowns=layout(runs, free),
            held_out=held_out,
            cabled=cabled,
            clocks=known,
            records=(
                stacked([runs[i] for i in cabled], known, sensors, height=height)
                if cabled
                else None
            ),
            motors=motors,
            motor_records=motor_record([runs[i] for i in motors], sensors) if motors else None,
        )

    def on_grid(self, step: float) -> "_Problem":
        """The same problem with intervals of about a given length [s]."""
        if self.records is None:
            return self
        duration = np.asarray(self.records.inputs.duration)
        factor = max(1, round(step / float(np.median(duration[duration > 0]))))
        return dataclasses.replace(self, records=coarse(self.records, factor))

    def at_rest(self) -> Float[np.ndarray, " n"]:
        """The point of the prior robot, every run starting where it was seen to."""
        unknowns = self.unknowns
        point = np.concatenate(
            [start_values(self.prior, unknowns), np.zeros(5 * len(self.runs))]
        )
        for row, run in enumerate(self.cabled):
            point[unknowns.of_run(run)[len(unknowns.free) :][:3]] = self.records.known[row, :3]
        return point

    def measurements(self) -> int:
        """Number of measurements that say something about the shared quantities."""
        count = 0
        for row, run in enumerate(self.cabled):
            if run not in self.held_out:
                count += 2 * int(jnp.sum(self.records.angle_weight[row] > 0))
                count += int(jnp.sum(self.records.frame_weight[row] > 0))
        for row, run in enumerate(self.motors):
            if run not in self.held_out:
                count += 2 * int(jnp.sum(self.motor_records.weight[row] > 0))
        return count

    def evaluate(
        self, point: Float[np.ndarray, " n"], *, held_out: bool = False
    ) -> tuple[Normal, Float[np.ndarray, "runs blocks n"]]:
        """Normal equations and scores of the fitted runs, or of those held out."""
        unknowns, parts = self.unknowns, []

        def chosen(runs: tuple[int, ...]) -> list[int]:
            return [run if (run in self.held_out) == held_out else -1 for run in runs]

        if self.records is not None:
            own = jnp.asarray(np.stack([point[unknowns.of_run(i)] for i in self.cabled]))
            sums = run_sums(self.prior, unknowns.free, own, self.records)
            parts.append(assemble(unknowns, chosen(self.cabled), sums, shared=not held_out))
        if self.motor_records is not None:
            own = jnp.asarray(np.stack([point[unknowns.local[i]] for i in self.motors]))
            sums = motor_sums(self.prior, unknowns.free, own, self.motor_records)
            parts.append(assemble(unknowns, chosen(self.motors), sums, shared=not held_out))
        normal = Normal(
            sum(part.cost for part, _ in parts),
            sum(part.gradient for part, _ in parts),
            sum(part.matrix for part, _ in parts),
        )
        return normal, np.concatenate([scores for _, scores in parts])

    def minimise(
        self,
        start: Float[np.ndarray, " n"],
        *,
        iterations: int,
        decrement: float,
        report: Callable[[int, float], None] = lambda iteration, cost: None,
        held_out: bool = False,
    ) -> Minimum:
        return minimise(
            lambda point: self.evaluate(point, held_out=held_out)[0],
            start,
            lower=self.unknowns.lower(),
            iterations=iterations,
            decrement=decrement,
            report=report,
        )


def _starts(problem: _Problem, progress: Progress) -> list[np.ndarray]:
    """Points to begin at: the best valleys of the scan."""
    unknowns = problem.unknowns
    base = _drives_alone(problem, problem.at_rest())
    scanned = {"friction_coefficient", PER_SETTING} & set(unknowns.free)
    if problem.records is None or PER_SETTING not in scanned:
        return [_with_knocks(problem, base)]
    rough = problem.on_grid(SCAN_STEP)
    points = [base.copy() for _ in range(STARTS)]
    friction = np.zeros((STARTS, 0))
    labels = sorted({label for name, label in unknowns.shared if name == PER_SETTING})
    for number, label in enumerate(labels):
        progress(f"scan at {label}", 0.1 * number / len(labels))
        valleys = _valleys(rough, base, label)
        if not valleys:
            continue
        chosen = [valleys[min(k, len(valleys) - 1)] for k in range(STARTS)]
        for point, (pretension, _) in zip(points, chosen, strict=True):
            point[unknowns.shared.index((PER_SETTING, label))] = np.log(pretension)
        forces = [[force / (4 * pretension)] for pretension, force in chosen]
        friction = np.concatenate([friction, forces], axis=1)
    if "friction_coefficient" in scanned and friction.size:
        for point, coefficient in zip(points, np.median(friction, axis=1), strict=True):
            index = unknowns.shared.index(("friction_coefficient", None))
            point[index] = encode("friction_coefficient", coefficient)
    unique = [
        p for k, p in enumerate(points) if not any(np.array_equal(p, q) for q in points[:k])
    ]
    return [_with_knocks(rough, point) for point in unique]


def _drives_alone(problem: _Problem, base: np.ndarray) -> np.ndarray:
    """The start with the drives' own quantities from the runs without the cable."""
    if problem.motor_records is None:
        return base
    alone = dataclasses.replace(problem, records=None)
    found = alone.minimise(base, iterations=30, decrement=1e-2)
    return found.point


def _valleys(problem: _Problem, base: np.ndarray, label: str) -> list[tuple[float, float]]:
    """Pretension [N] and friction force [N] of the scan's local minima, best first."""
    unknowns = problem.unknowns
    of_setting = [
        k
        for k, i in enumerate(problem.cabled)
        if problem.runs[i].pretension_label == label and i not in problem.held_out
    ]
    if not of_setting:
        return []
    reach = np.ptp(np.sum(np.asarray(problem.records.angle), axis=2), axis=1)
    still = np.array([problem.runs[problem.cabled[k]].knock is not None for k in of_setting])
    # A knock's force isn't known yet, so knocked runs are the last choice.
    order = sorted(range(len(of_setting)), key=lambda n: (still[n], -reach[of_setting[n]]))
    chosen = [of_setting[n] for n in order[:SCAN_RUNS]]

    grid = [(t, f) for t in PRETENSIONS for f in FRICTION_FORCES]
    pretension = unknowns.free.index(PER_SETTING)
    rows = []
    for t, f in grid:
        for k in chosen:
            row = base[unknowns.of_run(problem.cabled[k])].copy()
            row[pretension] = np.log(t)
            if "friction_coefficient" in unknowns.free:
                row[unknowns.free.index("friction_coefficient")] = encode(
                    "friction_coefficient", f / (4 * t)
                )
            rows.append(row)
    cost = scan(
        problem.prior, unknowns.free, np.stack(rows), chosen * len(grid), problem.records
    )
    total = cost.reshape(len(PRETENSIONS), len(FRICTION_FORCES), len(chosen)).sum(axis=2)
    over_friction = total.min(axis=1)
    padded = np.pad(over_friction, 1, constant_values=np.inf)
    minima = np.flatnonzero((over_friction <= padded[:-2]) & (over_friction <= padded[2:]))
    minima = minima[np.argsort(over_friction[minima])]
    return [(PRETENSIONS[k], FRICTION_FORCES[int(np.argmin(total[k]))]) for k in minima]


def _with_knocks(problem: _Problem, point: np.ndarray) -> np.ndarray:
    """The start with the forces of its knocks that fit best."""
    unknowns, point = problem.unknowns, point.copy()
    knocked = [k for k, i in enumerate(problem.cabled) if problem.runs[i].knock is not None]
    if not knocked:
        return point
    rows = []
    for k in knocked:
        for force in KNOCKS:
            row = point[unknowns.of_run(problem.cabled[k])].copy()
            row[len(unknowns.free) + 3] = force
            rows.append(row)
    cost = scan(
        problem.prior,
        unknowns.free,
        np.stack(rows),
        [k for k in knocked for _ in KNOCKS],
        problem.records,
    )
    for k, costs in zip(knocked, cost.reshape(len(knocked), len(KNOCKS)), strict=True):
        where = unknowns.of_run(problem.cabled[k])[len(unknowns.free) + 3]
        point[where] = KNOCKS[int(np.argmin(costs))]
    return point


def _judged(problem: _Problem, minimum: Minimum) -> dict[str, object]:
    """Robot, parameters and their correlation, from where the fit ended."""
    unknowns, point, lower = problem.unknowns, minimum.point, problem.unknowns.lower()
    _, scores = problem.evaluate(point)
    count = len(unknowns.shared)
    seen = free_unknowns(minimum.normal, point, lower)
    found = covariance(minimum.normal.matrix, scores, seen)
    parameters, robot = [], problem.prior
    for index, (name, setting) in enumerate(unknowns.shared):
        number = decode(name, point[index])
        # The logarithm's standard error is relative.
        sigma = found.sigma[index] * (number if quantity(name).positive else 1.0)
        at_bound = bool(point[index] <= lower[index])
        half = half_width(sigma, 0.95, found.degrees_of_freedom)
        parameters.append(
            ParameterEstimate(
                name=name,
                setting=setting,
                value=number,
                unit=quantity(name).unit,
                sigma=float(sigma),
                interval95=(number - half, number + half),
                status=judge(number, sigma, at_bound=at_bound),
                degrees_of_freedom=found.degrees_of_freedom,
            )
        )
    for parameter in reversed(parameters):
        robot = replace(robot, {parameter.name: parameter.value})
    return {
        "robot": robot,
        "parameters": (*parameters, *_fixed(robot, unknowns.free)),
        "correlation": found.correlation[:count, :count],
    }


def _fixed(robot: Robot, free: tuple[str, ...]) -> list[ParameterEstimate]:
    fixed = []
    for known in QUANTITIES:
        if known.name not in free:
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
    problem: _Problem, point: Float[np.ndarray, " n"]
) -> dict[str, Circumstances]:
    """What was estimated of each run; clocks with what was known of them before."""
    found = {}
    for run, known in zip(problem.cabled, problem.clocks, strict=True):
        own = point[problem.unknowns.of_run(run)[len(problem.unknowns.free) :]]
        lower, upper, height, knock, clock = (float(number) for number in own)
        found[problem.runs[run].name] = Circumstances(
            lower, upper, height, knock, clock + known.offset
        )
    return found


def _comparisons(
    problem: _Problem, point: Float[np.ndarray, " n"], campaign: Campaign
) -> tuple[Comparison, ...]:
    """Every run beside its simulation, in the campaign's order."""
    unknowns = problem.unknowns
    common = {
        "sensors": campaign.sensors,
        "held_out": frozenset(problem.runs[i].name for i in problem.held_out),
    }
    found: list[Comparison] = []
    if problem.records is not None:
        own = jnp.asarray(np.stack([point[unknowns.of_run(i)] for i in problem.cabled]))
        runs = tuple(problem.runs[i] for i in problem.cabled)
        found += compare(
            problem.prior, unknowns.free, own, problem.records, runs=runs, **common
        )
    if problem.motor_records is not None:
        own = jnp.asarray(np.stack([point[unknowns.local[i]] for i in problem.motors]))
        runs = tuple(problem.runs[i] for i in problem.motors)
        found += compare_motors(
            problem.prior, unknowns.free, own, problem.motor_records, runs=runs, **common
        )
    order = {run.name: number for number, run in enumerate(problem.runs)}
    return tuple(sorted(found, key=lambda comparison: order[comparison.name]))


def _require_float64() -> None:
    if not jax.config.jax_enable_x64:
        raise ValueError(
            "`estimate` needs float64, got float32: rounding would hide what the encoders "
            'resolve. Call `jax.config.update("jax_enable_x64", True)` first.'
        )
