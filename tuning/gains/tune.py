"""From a fitted robot and its measured frequencies to gains and shapers."""

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper, padded, residual_vibration
from scdpr_jax.legs.command_law import unshaped
from scdpr_jax.legs.ensemble import single
from scdpr_jax.legs.leg import Leg, leg_of
from scdpr_jax.native import kept_jit
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.parameters import Robot, exact
from tuning.gains.design import IMPULSES
from tuning.gains.manoeuvre import (
    COARSE_PERIOD,
    Task,
    alone,
    at_period,
    losses,
    runs,
    samples_for,
    track,
)
from tuning.gains.optimise import LEG_TIMES, Effort, optimise, search_preparations
from tuning.loop.admissible import admissible
from tuning.loop.flexible_margins import compile_margins
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import MotorPlant
from tuning.loop.worst_margins import margin_map, worst_margins
from tuning.regions.cells import Cell, Frequencies, cells_of, other_modes, robot_in
from tuning.regions.residual_map import worst_in_band
from tuning.result.prediction import Metrics, Prediction
from tuning.result.regional_shaper import RegionalShaper, ResidualVibration
from tuning.result.tuning import CAUTION, FittedSetting, Tuning
from tuning.shapers.catalogue import CATALOGUE

_SPAN = (0.3 / 2.224, 1.9 / 2.224)
"""Ends of Table 3's horizontal manoeuvre, as shares of the frame's width [1]."""
_HEIGHT = 0.55 / 1.112
"""Its height, as a share of the frame's [1]."""
_JUDGED = {
    "residual_vibration": "residual vibration",
    "resting_error": "resting error",
    "largest_error": "largest error against the commanded reference",
    "rms_error": "rms error against the commanded reference",
    "largest_original_error": "largest error against the unshaped reference (a shaper delays)",
}
"""Metrics that a note tells of where they became worse, by their field's name."""


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


def tune(
    estimate: Estimated,
    frequencies: Frequencies | None,
    *,
    leg_times: tuple[float, ...] = LEG_TIMES,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    force: bool = False,
    progress: Progress = SILENT,
) -> Tuning:
    """Gains for the robot and a shaper for every region of its workspace.

    Gains and a shaper are optimised on Table 3's horizontal manoeuvre in the cell that it
    lies in. In every other cell the shaper is the one that the simulation likes best there,
    of the catalogue's at the cell's frequency, the optimised one scaled to that frequency,
    and none at all.

    Args:
        estimate: The fitted robot.
        frequencies: The measured map; None, or without rows, for the model's frequencies.
        leg_times: Times of a leg that the design is optimised for [s].
        effort: How much is spent on the optimisation.
        force: Whether to tune for a robot whose fit has failed; the tuning is marked.
        progress: Told what is being done and which share of it is done.

    Returns:
        The tuning; its notes say where the model stood in for measurements, and which of
        the predicted metrics became worse.

    Raises:
        ValueError: If a measured setting has no fitted pretension, or the fit has failed.
    """
    caution = _caution(estimate, force=force)
    knocks = _Nowhere() if frequencies is None else frequencies
    settings = sorted({float(setting) for setting in knocks.pretension})
    robots = {setting: exact(estimate.of_setting(f"{setting:g} N")) for setting in settings}
    if not settings:
        nominal = float(estimate.robot.cable.effective_pretension)
        settings, robots = [nominal], {nominal: exact(estimate.robot)}
    cells = {s: cells_of(knocks, robots[s], pretension=s) for s in settings}
    # The middle setting stands for the others where the gains are concerned.
    setting = settings[len(settings) // 2]
    reference = _reference_cell(cells[setting], robots[setting])
    # What is promised for Table 3 is promised for the fitted robot as it is.
    task = _task(robots[setting], height=_HEIGHT * float(robots[setting].frame.height))
    progress("gains that keep their margins", 0.0)
    within = admissible(list(robots.values()))
    optimum = optimise(
        task,
        within,
        leg_times=leg_times,
        effort=effort,
        progress=progress.part(0.0, 0.8),
    )
    shapers = []
    for number, s in enumerate(settings):
        progress("shapers of the regions", 0.8 + 0.1 * number / len(settings))
        shapers += _shapers(
            cells[s],
            robots[s],
            optimum.controller,
            optimum.shaper,
            reference,
            s == setting,
            leg_times,
        )
    progress("manoeuvres before and after", 0.9)
    predicted = tuple(
        _predict(task, optimum.controller, optimum.shaper, leg_time, longest=max(leg_times))
        for leg_time in leg_times
    )
    fitted = tuple(FittedSetting(s, robot) for s, robot in robots.items())
    progress("margins over the workspace", 0.97)
    drive = robots[setting].drive
    plant = MotorPlant(gain=drive_gain(drive), pole=drive_pole(drive))
    return Tuning(
        controller=optimum.controller,
        margins=sampled_margins(plant, optimum.controller),
        shapers=tuple(shapers),
        predicted=predicted,
        robots=fitted,
        worst_margins=worst_margins(margin_map(fitted, optimum.controller)),
        notes=(*_other_modes(knocks, robots), *_notes(shapers, predicted)),
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


def _reference_cell(cells: tuple[Cell, ...], robot: Robot) -> Cell:
    """The cell in which Table 3's horizontal manoeuvre ends."""
    x, y = _SPAN[0] * float(robot.frame.width), _HEIGHT * float(robot.frame.height)
    return next(
        cell
        for cell in cells
        if cell.region.x[0] <= x <= cell.region.x[1]
        and cell.region.y[0] <= y <= cell.region.y[1]
    )


def _task(robot: Robot, *, height: float) -> Task:
    width = float(robot.frame.width)
    start, turn = (jnp.asarray([share * width, height]) for share in _SPAN)
    return Task(single(robot, start), turn)


def _shapers(
    cells: tuple[Cell, ...],
    robot: Robot,
    controller: PD,
    optimised: Shaper,
    reference: Cell,
    of_reference: bool,
    leg_times: tuple[float, ...],
) -> list[RegionalShaper]:
    """The best shaper of each cell; that of the reference cell is the optimised one."""
    coarse = at_period(COARSE_PERIOD, controller)
    candidates = _candidates(cells, optimised, reference)
    shape = candidates.times.shape[:2]
    tasks = [_task(robot_in(cell, robot), height=cell.height) for cell in cells]
    each = jax.tree.map(lambda *leaves: np.stack(leaves), *tasks)
    many = jax.tree.map(lambda leaf: np.repeat(leaf, shape[1], axis=0), each)
    tried = jax.tree.map(lambda leaf: leaf.reshape(-1, leaf.shape[-1]), candidates)
    total = np.zeros(shape)
    for leg in leg_times:
        before = runs(each, alone(), unshaped(optimised.times.size), leg)
        after = runs(many, coarse, tried, leg)
        shaped = jax.tree.map(lambda leaf: leaf.reshape(shape), after)
        against = jax.tree.map(lambda leaf: leaf[:, None], before)
        total = total + np.asarray(losses(shaped, against))
    chosen = []
    for number, cell in enumerate(cells):
        at = number, int(np.nanargmin(total[number]))
        best = jax.tree.map(lambda leaf, at=at: np.asarray(leaf)[at], candidates)
        is_optimised = of_reference and cell == reference
        chosen.append(_regional(cell, optimised if is_optimised else best))
    return chosen


_CELLS = 8
"""Cells whose shapers are designed in one call."""


@kept_jit
def _catalogue(
    frequency: Float[Array, " cells"], damping_ratio: Float[Array, " cells"], impulses: int
) -> tuple[Float[Array, "cells shapers impulses"], Float[Array, "cells shapers impulses"]]:
    """Times and amplitudes of the catalogue's shapers that are short enough, and of none.

    Idle impulses have no amplitude; where a shaper can't be made for a cell there is none.
    """

    def of_cell(*mode: Float[Array, ""]) -> tuple[Array, Array]:
        designs = [unshaped(), *(entry.design(*mode) for entry in CATALOGUE)]
        fitting = [padded(own, impulses) for own in designs if own.times.size <= impulses]
        times = jnp.stack([own.times for own in fitting])
        amplitudes = jnp.stack([own.amplitudes for own in fitting])
        made = jnp.isfinite(times + amplitudes).all(axis=1, keepdims=True)
        return jnp.where(made, times, times[0]), jnp.where(made, amplitudes, amplitudes[0])

    return jax.vmap(of_cell)(frequency, damping_ratio)


def _candidates(cells: Sequence[Cell], optimised: Shaper, reference: Cell) -> Shaper:
    """Shapers to try in each cell, the optimised one at the cell's frequency first."""
    frequency, damping_ratio = (
        np.array([getattr(cell, name) for cell in cells])
        for name in ("frequency", "damping_ratio")
    )
    # Some cells at a time, the first ones again at the end: one compiled function serves all.
    rows = np.arange(len(cells) + -len(cells) % _CELLS).reshape(-1, _CELLS) % len(cells)
    parts = [
        _catalogue(frequency[few], damping_ratio[few], optimised.times.size) for few in rows
    ]
    times, amplitudes = (
        np.concatenate(part)[: len(cells)] for part in zip(*parts, strict=True)
    )
    scaled = np.asarray(optimised.times) * (reference.frequency / frequency)[:, None]
    same = np.broadcast_to(optimised.amplitudes, scaled.shape)
    return Shaper(
        np.concatenate([scaled[:, None], times], axis=1),
        np.concatenate([same[:, None], amplitudes], axis=1),
    )


def _regional(cell: Cell, shaper: Shaper) -> RegionalShaper:
    times, amplitudes = np.asarray(shaper.times), np.asarray(shaper.amplitudes)
    used = amplitudes != 0
    kept = Shaper(times[used], amplitudes[used])

    damping_ratio = np.asarray(cell.damping_ratio)
    nominal = residual_vibration(
        kept, frequency=np.asarray(cell.frequency), damping_ratio=damping_ratio
    )
    worst = worst_in_band(kept, band=np.asarray(cell.band), damping_ratio=damping_ratio)
    return RegionalShaper(
        region=cell.region,
        height=cell.height,
        shaper=kept,
        frequency=cell.frequency,
        band=cell.band,
        damping_ratio=cell.damping_ratio,
        measured=cell.measured,
        residual_vibration=ResidualVibration(float(nominal), float(worst)),
    )


@kept_jit
def _run(
    task: Task, controller: PD, shaper: Shaper, leg_time: Float[Array, ""], samples: int
) -> list[Float[Array, "..."]]:
    """The arrays of a leg."""
    return jax.tree.leaves(track(task, controller, shaper, leg_time, samples=samples))


def preparations(
    robot: Robot, *, leg_times: tuple[float, ...] = LEG_TIMES
) -> Iterator[Callable[[], None]]:
    """What compiles what `tune` will run, on any robot, as it takes longer than running it.

    Args:
        robot: Any robot with the numbers of an ordinary one.
        leg_times: Times of a leg that the design will be optimised for [s].

    Yields:
        Functions that may be called in any order, and side by side.
    """
    task, any_pd = _task(exact(robot), height=_HEIGHT * float(robot.frame.height)), alone()
    yield from search_preparations(task, leg_times=leg_times)
    yield functools.partial(compile_margins, task.ensemble.robot, any_pd)
    modes = np.ones(_CELLS), np.zeros(_CELLS)
    yield functools.partial(_catalogue.compile, *modes, IMPULSES)
    nothing, longest = unshaped(IMPULSES), max(leg_times)
    yield lambda: _predict(task, published_pd(), nothing, leg_times[0], longest=longest)


def _predict(
    task: Task, controller: PD, shaper: Shaper, leg_time: float, *, longest: float
) -> Prediction:
    """A manoeuvre at the controllers' own rate, before and after."""
    leg = jnp.asarray(leg_time)
    count = shaper.times.size

    def simulate(pd: PD, impulses: Shaper) -> tuple[Metrics, Leg]:
        # As many for every leg time, so that it compiles once; the rest is cut off.
        most, samples = (samples_for(t, float(pd.period)) for t in (longest, leg_time))
        run = leg_of(_run(task, pd, impulses, leg, most))
        return Metrics.of(run.measures), run.until(samples)

    before, run_before = simulate(published_pd(), padded(unshaped(), count))
    after, run_after = simulate(controller, shaper)
    name = f"horizontal manoeuvre, {leg_time:g} s a leg"
    return Prediction(name, before, after, run_before, run_after)


def _other_modes(knocks: Frequencies, robots: dict[float, Robot]) -> list[str]:
    return [
        f"The knock at x {knocks.x[row]:.2f} m, y {knocks.y[row]:.2f} m and {setting:g} N "
        f"rings at {knocks.frequency[row]:.2f} Hz, in another mode than the sway that shapers "
        "are for: it says nothing of them. Knock there anew, with the drives held."
        for setting, robot in robots.items()
        for row in other_modes(knocks, robot, pretension=setting)
    ]


def _notes(shapers: list[RegionalShaper], predicted: tuple[Prediction, ...]) -> tuple[str, ...]:
    notes = []
    modelled = sum(not shaper.measured for shaper in shapers)
    if modelled:
        notes.append(
            f"{modelled} of {len(shapers)} regions have no knock: their frequency is the "
            "model's, with both carriages held by friction. Knock there to measure it."
        )
    for prediction in predicted:
        worse = [
            words
            for name, words in _JUDGED.items()
            if getattr(prediction.after, name) > getattr(prediction.before, name)
        ]
        if worse:
            notes.append(f"{prediction.name}: worse than before in {', '.join(worse)}.")
    return tuple(notes)
