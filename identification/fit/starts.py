"""Where a fit begins: from the drives alone, a scan, and its valleys followed down.

The vibration's phase wraps, so a fit that starts at the wrong pretension ends in a local
minimum. A scan over pretension and friction on a coarse grid finds the valleys; a few runs
are enough to follow all of them to their ends, side by side.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from identification.data.circumstances import START
from identification.fit.problem import Problem
from identification.fit.run_sums import run_misfit
from identification.fit.unknowns.unknowns import PER_SETTING, decode, encode
from scdpr_jax.numerics.progress import Progress
from scdpr_jax.robot.quantities import value

SCAN_RUNS = 2
"""Runs of a setting that the scan looks at: those that move the furthest sideways."""

LANES = 120
"""Simulations of a chunk; a fixed number, so that one compilation serves every scan."""

VALLEYS = 6
"""Valleys of the scan that are followed down."""

SAME = 0.01
"""Relative difference of pretensions below which two ends are the same minimum [1]."""

PRETENSIONS = tuple(float(t) for t in 15 * 1.06 ** np.arange(68))
"""Effective pretensions to try [N]: 6 % apart, as far as the phase of a few periods goes."""

FRICTION_FORCES = tuple(float(f) for f in 0.4 * 1.6 ** np.arange(11))
"""Friction forces of a carriage to try, 4Tμ, 0.4 to 44 N [N]."""

KNOCKS = tuple(float(f) for s in (-1, 1) for f in s * 2.0 * 1.25 ** np.arange(20))
"""Forces of a knock to try [N]."""

ROTOR = "drive_inertia"

ROTORS = (1.0, 1.4, 0.7, 2.0)
"""Inertias of the drives to begin with, over the prior's [1]."""

EXPLAINED = 2.0
"""Misfit of a measurement up to which the bare drives' runs are explained [1]."""

FRICTION = "friction_coefficient"


@dataclasses.dataclass(frozen=True)
class Valley:
    """A minimum of the misfit over pretension and friction, by a few runs of a setting."""

    setting: str
    """Nominal pretension."""
    pretension: float
    """Effective pretension [N]."""
    friction_coefficient: float
    """Coefficient of friction of the carriages [1]."""
    misfit: float
    """Misfit per measurement of these runs [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Starts:
    """Where a fit begins, and what else there was."""

    points: tuple[Float[np.ndarray, " n"], ...]
    """Vectors of the fit, the most promising first; seldom more than one."""
    valleys: tuple[Valley, ...]
    """Every distinct minimum that the scan's valleys led to, by setting, the best first."""


AMBIGUOUS = 1.3
"""Misfit over the least one up to which a valley is tried on all runs, too [1]."""


def starts(problem: Problem, progress: Progress) -> Starts:
    """Points to begin a fit at.

    Args:
        problem: The problem.
        progress: Told what is being done and which share of it is done.

    Returns:
        The points, with the valleys that they come from.
    """
    base = _drives_alone(problem, problem.at_rest())
    logs, unknowns = problem.logs, problem.unknowns
    for row, run in enumerate(logs.cabled):
        if logs.runs[run].knock is not None:
            base[unknowns.circumstance(run, "knock")] = _seen_knock(problem, row)
    labels = sorted({label for name, label in unknowns.shared if name == PER_SETTING})
    scanned = logs.records is not None and bool(labels)
    if not scanned or not unknowns.opened[unknowns.place(PER_SETTING, labels[0])]:
        return Starts((_with_knocks(problem, base),), ())
    points, valleys = [base], []
    for number, label in enumerate(labels):
        progress(f"scan at {label}", number / len(labels))
        ends = _valleys(problem, base, label)
        valleys += [valley for valley, _ in ends]
        if ends:
            least = ends[0][0].misfit
            close = [end for valley, end in ends if valley.misfit <= AMBIGUOUS * least]
            points = [_joined(problem, point, end, label) for point in points for end in close]
    points = [_with_knocks(problem, _one_friction(problem, point, valleys)) for point in points]
    return Starts(tuple(points[:VALLEYS]), tuple(valleys))


def _drives_alone(problem: Problem, base: np.ndarray) -> np.ndarray:
    """The start with the drives' own quantities from the runs without the cable."""
    if problem.logs.motor_records is None:
        return base
    # What was measured at a setting says nothing of the drives until its runs are there.
    common = [number for number in problem.options.measured if number.setting is None]
    alone = dataclasses.replace(
        problem,
        logs=problem.logs.of_drives(),
        options=dataclasses.replace(problem.options, measured=common),
    )
    count = max(sum(alone.logs.measurements(run) for run in alone.fitted()), 1.0)
    ends = []
    for begun in _other_rotors(problem, base):
        ends.append(alone.minimise(begun, iterations=30, decrement=1e-2))
        if ends[-1].normal.cost < EXPLAINED * count:
            break
    return min(ends, key=lambda end: end.normal.cost).point


def _other_rotors(problem: Problem, base: np.ndarray) -> list[np.ndarray]:
    """A start, and the same with other inertias where they are free.

    A run that begins in motion has little of the transient that tells the inertia, and from far
    off it is explained as well by a drive without any.
    """
    unknowns = problem.unknowns
    if (ROTOR, None) not in unknowns.shared or not unknowns.opened[unknowns.place(ROTOR)]:
        return [base]
    starts = [base.copy() for _ in ROTORS]
    for start, factor in zip(starts, ROTORS, strict=True):
        start[unknowns.place(ROTOR)] += np.log(factor)
    return starts


def _valleys(problem: Problem, base: np.ndarray, label: str) -> list[tuple[Valley, np.ndarray]]:
    """Distinct minima at a setting with the vectors that they are at, the best first."""
    rows = _telling_runs(problem, label)
    if not rows:
        return []
    minima = _scanned(problem, base, label, rows)[:VALLEYS]
    ends = problem.minimise_on(rows, minima, iterations=12, decrement=1.0, share=1e-3)
    count = sum(problem.logs.measurements(problem.logs.cabled[row]) for row in rows)
    distinct: list[tuple[Valley, np.ndarray]] = []
    for end in sorted(ends, key=lambda end: end.normal.cost):
        valley = Valley(
            label,
            decode(PER_SETTING, end.point[problem.unknowns.place(PER_SETTING, label)]),
            _friction(problem, end.point),
            end.normal.cost / count,
        )
        if all(
            abs(valley.pretension - other.pretension) > SAME * other.pretension
            for other, _ in distinct
        ):
            distinct.append((valley, end.point))
    return distinct


def _telling_runs(problem: Problem, label: str) -> list[int]:
    """The runs of a setting that move the furthest sideways; knocked ones only at need."""
    logs = problem.logs
    of_setting = [
        row
        for row, run in enumerate(logs.cabled)
        if logs.runs[run].pretension_label == label and run not in problem.held_out
    ]
    reach = np.ptp(np.sum(np.asarray(logs.records.angle), axis=2), axis=1)

    def rank(row: int) -> tuple[bool, bool, float]:
        # A knock's force isn't known yet, and a start in motion only roughly.
        run = logs.runs[logs.cabled[row]]
        return run.knock is not None, run.in_motion, -float(reach[row])

    return sorted(of_setting, key=rank)[:SCAN_RUNS]


def _scanned(
    problem: Problem, base: np.ndarray, label: str, rows: Sequence[int]
) -> list[np.ndarray]:
    """The minima of a scan over pretension and friction, the best first."""
    points = [_at(problem, base, label, t, f) for t in PRETENSIONS for f in FRICTION_FORCES]
    cost = _misfits(problem, [x for x in points for _ in rows], list(rows) * len(points))
    total = cost.reshape(len(PRETENSIONS), len(FRICTION_FORCES), len(rows)).sum(axis=2)
    over_friction = total.min(axis=1)
    padded = np.pad(over_friction, 1, constant_values=np.inf)
    minima = np.flatnonzero((over_friction <= padded[:-2]) & (over_friction <= padded[2:]))
    minima = minima[np.argsort(over_friction[minima])]
    return [points[k * len(FRICTION_FORCES) + int(np.argmin(total[k]))] for k in minima]


def _at(
    problem: Problem, base: np.ndarray, label: str, pretension: float, force: float
) -> np.ndarray:
    """The base with a pretension and a friction force."""
    point, unknowns = base.copy(), problem.unknowns
    point[unknowns.place(PER_SETTING, label)] = encode(PER_SETTING, pretension)
    if (FRICTION, None) in unknowns.shared:
        point[unknowns.place(FRICTION)] = encode(FRICTION, force / (4 * pretension))
    return point


def _seen_knock(problem: Problem, row: int) -> float:
    r"""Force of a knock by the first frame after it, $F = m_e \Delta x / (\Delta t\, t_F)$."""
    run, record = problem.logs.runs[problem.logs.cabled[row]], problem.logs.records
    weight = np.asarray(record.frame_weight)[row, :, 0]
    stamps = np.asarray(record.frame_time)[row]
    ended = run.knock.start + run.knock.duration - run.drive.time[0]
    after = np.flatnonzero((weight > 0) & (stamps > ended))
    if after.size == 0:
        return KNOCKS[-1] / 4
    lower, upper, height = np.asarray(record.prior.mean)[row, START]
    robot = problem.prior
    at_rest = lower - (lower - upper) / float(value(robot, "frame_height")) * height
    moved = float(np.asarray(record.frame)[row, after[0], 0]) - at_rest
    time = float(stamps[after[0]]) - ended + run.knock.duration / 2
    return float(value(robot, "end_effector_mass")) * moved / (time * run.knock.duration)


def _joined(problem: Problem, point: np.ndarray, end: np.ndarray, label: str) -> np.ndarray:
    """A point with what a valley says of its setting, and of everything else it freed."""
    joined = end.copy()
    for index, (name, setting) in enumerate(problem.unknowns.shared):
        if name == PER_SETTING and setting != label:
            joined[index] = point[index]
    first = len(problem.unknowns.shared)
    joined[first:] = point[first:]
    return joined


def _one_friction(problem: Problem, point: np.ndarray, valleys: list[Valley]) -> np.ndarray:
    """The friction that the best valleys of all settings have in the middle."""
    labels = {valley.setting for valley in valleys}
    if len(labels) < 2 or (FRICTION, None) not in problem.unknowns.shared:
        return point
    best = [next(v for v in valleys if v.setting == label) for label in labels]
    point = point.copy()
    middle = float(np.median([valley.friction_coefficient for valley in best]))
    point[problem.unknowns.place(FRICTION)] = encode(FRICTION, middle)
    return point


def _with_knocks(problem: Problem, point: np.ndarray) -> np.ndarray:
    """The start with the forces of its knocks that fit best."""
    logs, unknowns, point = problem.logs, problem.unknowns, point.copy()
    knocked = [k for k, i in enumerate(logs.cabled) if logs.runs[i].knock is not None]
    if not knocked:
        return point
    points, rows = [], [k for k in knocked for _ in KNOCKS]
    for k in knocked:
        for force in KNOCKS:
            points.append(point.copy())
            points[-1][unknowns.circumstance(logs.cabled[k], "knock")] = force
    cost = _misfits(problem, points, rows).reshape(len(knocked), len(KNOCKS))
    for k, best in zip(knocked, np.argmin(cost, axis=1), strict=True):
        point[unknowns.circumstance(logs.cabled[k], "knock")] = KNOCKS[best]
    return point


def _misfits(
    problem: Problem, points: Sequence[np.ndarray], rows: Sequence[int]
) -> Float[np.ndarray, " count"]:
    """Misfit of a run at each point, on the coarser grid."""
    return problem.in_lanes(run_misfit, points, rows, records=problem.logs.rough, size=LANES)


def _friction(problem: Problem, point: np.ndarray) -> float:
    if (FRICTION, None) in problem.unknowns.shared:
        return decode(FRICTION, point[problem.unknowns.place(FRICTION)])
    return float(value(problem.prior, FRICTION))
