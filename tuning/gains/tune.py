"""From a fitted robot and its measured frequencies to gains and shapers."""

import concurrent.futures
import dataclasses
import functools
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.parameters import Robot, exact
from tuning.gains.legs import Legs, plain_law
from tuning.gains.loss import loss
from tuning.gains.manoeuvre import HEIGHT, LEG_TIMES, SPAN, predict
from tuning.gains.notes import notes_of
from tuning.gains.optimise import Effort, Optimum, optimise, scaled
from tuning.gains.outcome import outcome
from tuning.gains.planned_legs import planned_legs
from tuning.gains.possible_robots import Draws, PossibleRobot, possible_robots
from tuning.gains.regional import (
    LEGS,
    NONE,
    Candidates,
    candidates,
    cell_at,
    choose,
    legs_anywhere,
    legs_into,
    told,
)
from tuning.loop.admissible import Admissible, admissible
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import MotorPlant
from tuning.loop.worst_margins import margin_map, worst_margins
from tuning.regions.cells import Cell, Frequencies, cells_of
from tuning.result.prediction import LegsOutcome, PredictedLegs
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import CAUTION, FittedSetting, Tuning

PREDICTED = 40
"""Random legs that a tuning is predicted on, none of which it was made for."""
_SEARCHED, _CHOSEN, _TOLD = 11, 1000, 5
"""Seeds of the legs that are searched on, that regions are chosen on, and predicted."""
_KEPT = 2
"""Kinds of shapers that are tried in every region beside none, the best over the workspace."""


@runtime_checkable
class Estimated(Protocol):
    """A fitted robot, at every pretension setting."""

    @property
    def robot(self) -> Robot:
        """The robot at its first setting."""

    def of_setting(self, label: str) -> Robot:
        """The robot at a setting such as "350 N"."""


@runtime_checkable
class Judged(Protocol):
    """What knows whether the fit that it comes from has failed."""

    @property
    def fits(self) -> bool:
        """Whether it hasn't."""


class _Nowhere:
    """A map of no knocks."""

    x = y = pretension = frequency = frequency_sigma = damping_ratio = np.zeros(0)


class _Setting(NamedTuple):
    """A pretension with its robots and cells."""

    fitted: FittedSetting
    robots: tuple[PossibleRobot, ...]
    cells: tuple[Cell, ...]


class _Seen(NamedTuple):
    """Legs with what they come to under Eq. (25) alone."""

    legs: Legs
    cells: list[int]
    before: LegsOutcome


def tune(
    estimate: Estimated,
    frequencies: Frequencies | None,
    *,
    draws: Draws | None = None,
    leg_times: tuple[float, ...] = LEG_TIMES,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    force: bool = False,
    processes: concurrent.futures.Executor | None = None,
    progress: Progress | bool = SILENT,
) -> Tuning:
    """Gains for the robot and a shaper for every region of its workspace.

    Gains and a shaper are optimised over random legs and robots as they might be. In every
    region the shaper is the one that legs which end there like best, of the optimised one and
    the catalogue's, at the region's frequency, and none at all. Gains under which some region
    or the resting error would be worse than under Eq. (25) are given up for those of Eq. (25).

    Args:
        estimate: The fitted robot.
        frequencies: The measured map; None, or without rows, for the model's frequencies.
        draws: Robots at a setting as the fit's covariance leaves them possible; None where it
            isn't known.
        leg_times: Times of a leg of the manoeuvre that is simulated before and after [s].
        effort: How much is spent on the optimisation.
        force: Whether to tune for a robot whose fit has failed; the tuning is marked.
        processes: Who plans legs meanwhile, see `tuning.plan.planning.plan_legs`.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The tuning; its notes say what is predicted of it, and where the model stood in for
        measurements.

    Raises:
        ValueError: If a measured setting has no fitted pretension, or the fit has failed.
    """
    progress = listening(progress)
    caution = _caution(estimate, force=force)
    knocks = _Nowhere() if frequencies is None else frequencies
    settings = _settings(estimate, knocks, draws)
    # The middle setting stands for the others where the gains are concerned.
    main = settings[len(settings) // 2]
    progress("gains that keep their margins", 0.0)
    within = admissible([setting.fitted.robot for setting in settings])
    optimum = _optimum(main, within, effort, progress.part(0.1, 0.7, "gains and shaper"))
    inner = progress.part(0.7, 0.95, "shapers of the regions, and legs as planned")
    inner("", 0.0)
    seen = _seen(main, count=PREDICTED, seed=_TOLD)
    some = seen.legs.rows(np.arange(effort.planned))
    plans = functools.partial(
        planned_legs, main.fitted.robot, legs=some, processes=processes, progress=inner
    )
    with concurrent.futures.ThreadPoolExecutor(1) as aside:
        # Gains are seldom given up, so legs are planned under them meanwhile.
        planned = aside.submit(plans, optimum.controller)
        controller, shapers, legs = _never_worse(settings, main, seen, optimum)
        if controller is not optimum.controller:
            planned = aside.submit(plans, controller)
    if effort.planned:
        legs = dataclasses.replace(legs, planned=planned.result())
    progress("manoeuvres before and after", 0.95)
    here = next(s for s in shapers if s.region == main.cells[_reference(main)].region)
    predicted = predict(main.fitted.robot, controller, here.shaper, leg_times=leg_times)
    fitted = tuple(setting.fitted for setting in settings)
    drive = main.fitted.robot.drive
    plant = MotorPlant(gain=drive_gain(drive), pole=drive_pole(drive))
    return Tuning(
        controller=controller,
        margins=sampled_margins(plant, controller),
        shapers=tuple(shapers),
        predicted=predicted,
        robots=fitted,
        worst_margins=worst_margins(margin_map(fitted, controller)),
        notes=notes_of(knocks, fitted, shapers, legs, predicted),
        legs=legs,
        caution=caution,
    )


def _caution(estimate: Estimated, *, force: bool) -> str:
    """What a tuning for this robot has to warn of."""
    if not isinstance(estimate, Judged) or estimate.fits:
        return ""
    if not force:
        raise ValueError(
            "the model doesn't fit the runs that these parameters come from, got the status "
            "model_does_not_fit, expected values that hold. Gains for a robot that isn't the "
            "one on the rig can shake it to pieces. Find the cause first; `--force` (`force` "
            "in Python) tunes all the same, and marks every file."
        )
    return CAUTION


def _settings(
    estimate: Estimated, knocks: Frequencies | _Nowhere, draws: Draws | None
) -> list[_Setting]:
    """The settings that were measured, or the fitted one."""
    measured = sorted({float(setting) for setting in knocks.pretension})
    robots = {setting: exact(estimate.of_setting(f"{setting:g} N")) for setting in measured}
    if not robots:
        robots = {float(estimate.robot.cable.effective_pretension): exact(estimate.robot)}
    return [
        _Setting(
            FittedSetting(setting, robot),
            possible_robots(
                robot, [exact(r) for r in draws(setting)] if draws and measured else ()
            ),
            cells_of(knocks, robot, pretension=setting),
        )
        for setting, robot in robots.items()
    ]


def _reference(setting: _Setting) -> int:
    """The cell in which Table 3's horizontal manoeuvre ends: shapers are scaled from it."""
    frame = setting.fitted.robot.frame
    place = np.array([SPAN[0] * float(frame.width), HEIGHT * float(frame.height)])
    return cell_at(setting.cells, place)


def _slower(main: _Setting, setting: _Setting) -> float:
    """By how much a setting's vibration is slower than that of the one tuned at [1]."""
    fast, slow = (each.cells[_reference(each)].frequency for each in (main, setting))
    return fast / slow


def _seen(setting: _Setting, *, count: int, seed: int) -> _Seen:
    legs, inside = legs_anywhere(setting.cells, setting.robots, count=count, seed=seed)
    return _Seen(legs, inside, outcome(legs, plain_law()))


def _optimum(main: _Setting, within: Admissible, effort: Effort, progress: Progress) -> Optimum:
    seen = _seen(main, count=effort.legs, seed=_SEARCHED)
    return optimise(
        seen.legs,
        within,
        before=seen.before,
        frequency=main.cells[_reference(main)].frequency,
        effort=effort,
        progress=progress,
    )


def _never_worse(
    settings: list[_Setting], main: _Setting, seen: _Seen, optimum: Optimum
) -> tuple[PD, list[RegionalShaper], PredictedLegs]:
    """Shapers for the optimised gains, or for those of Eq. (25) where these are worse."""
    own = [scaled(optimum.shaper, _slower(main, setting)) for setting in settings]
    into = [
        legs_into(setting.cells, setting.robots, count=LEGS, seed=_CHOSEN)
        for setting in settings
    ]
    plain = [[outcome(part, plain_law()) for part in parts] for parts in into]
    for controller in (optimum.controller, published_pd()):
        every = candidates(main.cells, optimum.shaper)
        names = _best_kinds(main, seen, controller, every)
        shapers = []
        for setting, parts, before, shaper in zip(settings, into, plain, own, strict=True):
            tried = candidates(setting.cells, shaper).only(names)
            shapers += choose(setting.cells, parts, before, controller, tried)
        legs = _predicted(main, seen, controller, shapers)
        if _is_no_worse(shapers, legs):
            break
    return controller, shapers, legs


_SHORT_OF_LUCK = 1.05
"""Mean resting error over the plain profile's that is no worse [1]: forty legs tell no less."""


def _is_no_worse(shapers: list[RegionalShaper], legs: PredictedLegs) -> bool:
    resting = legs.after.resting_error.mean() <= _SHORT_OF_LUCK * (
        legs.before.resting_error.mean()
    )
    return bool(resting) and all(shaper.share <= 1 for shaper in shapers)


def _best_kinds(
    main: _Setting, seen: _Seen, controller: PD, tried: Candidates
) -> tuple[str, ...]:
    """The kinds of shapers that do best by the robot that each serves worst, then none."""
    shapers = [
        tried.shapers[cell][number] for number in range(len(tried.names)) for cell in seen.cells
    ]
    crossed = len(tried.names), len(seen.cells)
    every = seen.legs.rows(np.tile(np.arange(crossed[1]), crossed[0]))
    laws = told(controller, shapers, legs=[1] * len(shapers))
    after = outcome(every, laws).map(lambda own: own.reshape(crossed))
    count = len(main.robots)
    by_robot = [
        loss(
            after.map(lambda own, k=k: own[:, k::count]),
            seen.before.map(lambda own, k=k: own[k::count]),
        )
        for k in range(count)
    ]
    order = np.argsort(np.max(by_robot, axis=0), kind="stable")
    best = [tried.names[k] for k in order if tried.names[k] != NONE]
    return (*best[:_KEPT], NONE)


def _predicted(
    main: _Setting, seen: _Seen, controller: PD, shapers: list[RegionalShaper]
) -> PredictedLegs:
    """The legs under the chosen gains and shapers."""
    by_region = {shaper.region: shaper.shaper for shaper in shapers}
    own: list[Shaper] = [by_region[main.cells[cell].region] for cell in seen.cells]
    after = outcome(seen.legs, told(controller, own, legs=[1] * len(own)))
    return PredictedLegs(seen.before, after, len(main.robots))
