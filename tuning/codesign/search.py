"""Gains, impulses and the leg's shape together, for the worst of many models.

The models are many and their worst share decides, so the work is done where it is cheap: the
catalogue's shapers are ranked, and descended from, on a few of the models; all of them see
only the last descent, and what is found is run at the controllers' own rate.
"""

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.command_law import unshaped as no_shaper
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.linear.modes import held_frequency
from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.codesign.models import Models
from tuning.codesign.outcomes import Command, Grid, Outcome, grid, linearise, run
from tuning.codesign.tail import descend, value_at_risk
from tuning.codesign.unknowns import IMPULSES, Law, Unknowns, command, law, plain_profile, start
from tuning.loop.admissible import Admissible
from tuning.shapers.catalogue import CATALOGUE

SHARE = 0.1
"""Share of the models, the worst of them, that a design is judged by [1]."""
COARSE, FINE = 2e-3, 1e-3
"""Sample period of the search, and the controllers' own [s]."""

_FEW = 120
"""Models that the search begins on."""
_FEW_SHARE = 0.2
"""Share of them that counts [1]: as many that one chunk's Jacobians are used."""
_STARTS = 2
"""Starts that are descended from."""
_STEPS, _LAST_STEPS = 12, 8
"""Steps of a descent on a few of the models, and on all."""
_WISH = (60.0, np.deg2rad(60.0))
"""Crossover and phase margin of a bare drive that a search starts with, or what comes nearest
to them within the bounds [rad/s, rad]; Eq. (25) has 40 rad/s."""


class _Start(NamedTuple):
    """Where a descent may start."""

    law: Law
    """The design exactly."""
    point: Float[np.ndarray, " n"]
    """The flat unknowns of nearly the same one."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Designed:
    """A design and what it comes to."""

    law: Law
    """Gains, impulses and leg."""
    move_time: float
    """Time from the reference's begin to its end, the shaper included [s]."""
    outcomes: Outcome
    """What every model comes to under it, at the controllers' own rate."""
    point: Float[np.ndarray, " n"] | None = None
    """Its flat unknowns, where a descent ended in it."""

    def __repr__(self) -> str:
        controller = self.law.controller
        return (
            f"Designed: moves of {self.move_time:.4g} s, PD of "
            f"{float(controller.proportional_gain):.4g} V/rad and "
            f"{float(controller.derivative_gain):.4g} V s/rad, "
            f"{self.law.shaper.times.size} impulses; worst tenth vibrates "
            f"{1e3 * self.vibration:.3g} mm"
        )

    @property
    def measures(self) -> LegMeasures:
        """What each leg comes to, in numbers."""
        return self.outcomes.measures

    @property
    def cost(self) -> float:
        """Mean cost of the worst `SHARE` of the models [1]."""
        return value_at_risk(np.asarray(self.outcomes.cost), SHARE)

    @property
    def vibration(self) -> float:
        """Mean vibration of the worst `SHARE` of the models, peak to peak [m]."""
        return value_at_risk(np.asarray(self.measures.residual_vibration), SHARE)

    def keeps_voltage(self, limit: float) -> bool:
        """Whether no model's drives come to their limit.

        Args:
            limit: Largest command [V].

        Returns:
            Whether none does.
        """
        return bool(np.max(self.measures.largest_voltage) < limit)


def co_design(
    models: Models,
    within: Admissible,
    *,
    move_time: float,
    longest: float | None = None,
    begin: Sequence[Designed] = (),
    progress: Progress = SILENT,
) -> Designed:
    """The design that is best for the worst of many models.

    Args:
        models: The models.
        within: Which gains are admissible.
        move_time: Time from the reference's begin to its end, the shaper included [s].
        longest: Longest move that will be asked for [s]: one compilation then serves all;
            None for this one.
        begin: Designs of other move times to start from beside the catalogue's.
        progress: Told what is being done and which share of it is done.

    Returns:
        The best design seen, at the worst the best of the catalogue's; where one keeps the
        drives within their limit, one that does.
    """
    on = grid(longest or move_time, COARSE)
    few = models.rows(scattered(len(models), _FEW))
    progress("co-design: shapers of the catalogue", 0.0)
    objective = Objective(within, jnp.asarray(move_time), on)
    points = [one.point for one in begin if one.point is not None]
    starts = _ranked(
        few,
        on,
        [_Start(objective.law(jnp.asarray(point)), point) for point in points]
        + _starts(models, within, move_time),
    )
    ended = []
    for number, (_, point) in enumerate(starts[:_STARTS]):
        begun = 0.1 + 0.2 * number
        ended.append(
            descend(
                *objective.of(few),
                point,
                share=_FEW_SHARE,
                iterations=_STEPS,
                progress=progress.part(begun, begun + 0.2, "co-design: a few models"),
            )
        )
    best = min(ended, key=lambda one: one.normal.cost).point
    last = descend(
        *objective.of(models),
        best,
        share=SHARE,
        iterations=_LAST_STEPS,
        progress=progress.part(0.5, 0.9, "co-design: all models"),
    )
    progress("co-design: at the controllers' rate", 0.9)
    ends = (_Start(objective.law(jnp.asarray(last.point)), last.point), starts[0])
    designs = [
        dataclasses.replace(evaluate(models, end.law, longest=longest), point=end.point)
        for end in ends
    ]
    return best_of(designs, models)


def best_of(designs: Sequence[Designed], models: Models) -> Designed:
    """The design of the least cost, of those that keep the drives' limit if any does.

    Args:
        designs: The designs, evaluated on the same models.
        models: These.

    Returns:
        The best one, the first of equals.
    """
    limit = float(np.min(models.ensemble.robot.drive.voltage_limit))
    return min(designs, key=lambda one: (not one.keeps_voltage(limit), one.cost))


def evaluate(models: Models, law: Law, *, longest: float | None = None) -> Designed:
    """What a design comes to at the controllers' own rate.

    Args:
        models: The models.
        law: The design.
        longest: Longest move of all that will be looked at [s], so that one compilation
            serves them; None for this one.

    Returns:
        The design with what every model comes to.
    """
    time = float(law.leg_time + law.shaper.duration)
    on = grid(longest or time, FINE)
    return Designed(law, time, run(models, _told(law, on=on), on))


def unshaped(controller: PD, *, move_time: float) -> Law:
    """A controller on the plain leg of section 6.2.

    Args:
        controller: The controller.
        move_time: Time of the leg [s].

    Returns:
        The law.
    """
    return shaped(controller, no_shaper(), move_time=move_time)


def shaped(controller: PD, shaper: Shaper, *, move_time: float) -> Law:
    """A controller on the plain leg of section 6.2, shaped, in the same time.

    Args:
        controller: The controller.
        shaper: The impulses, `IMPULSES` at the most, shorter than the move.
        move_time: Time of leg and shaper [s].

    Returns:
        The law.
    """
    idle = IMPULSES - shaper.times.size
    # As many for every shaper, so that what follows compiles once.
    whole = Shaper(
        jnp.concatenate([shaper.times, jnp.full(idle, shaper.times[-1])]),
        jnp.concatenate([shaper.amplitudes, jnp.zeros(idle)]),
    )
    return Law(
        controller,
        whole,
        jnp.asarray(plain_profile()),
        jnp.asarray(move_time) - shaper.duration,
    )


def references(models: Models, *, move_time: float) -> dict[str, Law]:
    """What a design is compared with: Eq. (25) as it is, and with a ZV shaper.

    Args:
        models: The models.
        move_time: Time of the move, the shaper included [s].

    Returns:
        The laws by name.
    """
    _, middle, _ = held_frequencies(models)
    zv = CATALOGUE[0].design(middle, 0.0)
    return {
        "Eq. (25)": unshaped(published_pd(), move_time=move_time),
        "Eq. (25) and ZV": shaped(published_pd(), zv, move_time=move_time),
    }


def held_frequencies(models: Models) -> tuple[float, float, float]:
    """Natural frequencies of the models while friction holds both carriages.

    Args:
        models: The models.

    Returns:
        The lowest, the median and the highest [Hz].
    """
    frequencies = _held(models)
    return (
        float(jnp.min(frequencies)),
        float(jnp.median(frequencies)),
        float(jnp.max(frequencies)),
    )


@jax.jit
def _held(models: Models) -> Float[Array, " n"]:
    return jax.vmap(lambda model: held_frequency(model.ensemble.robot, model.end[1]))(models)


def scattered(count: int, most: int) -> np.ndarray:
    """Some of many rows, spread over all of them whatever order they are in.

    Args:
        count: How many there are.
        most: How many are wanted at the most.

    Returns:
        Their numbers, ascending.
    """
    # In random order, as a stride could miss poses that come again with it.
    return np.sort(np.random.default_rng(0).permutation(count)[:most])


class Objective(NamedTuple):
    """From flat unknowns to costs and Jacobians of models on a grid."""

    within: Admissible
    """Which gains are admissible."""
    move_time: Float[Array, ""]
    """Time of the move [s]."""
    on: Grid
    """The samples."""

    def law(self, point: Float[Array, " n"]) -> Law:
        """The design at a point.

        Args:
            point: Flat unknowns.

        Returns:
            The law.
        """
        return law(Unknowns.of(point), self.move_time, self.within)

    def of(self, models: Models) -> tuple[Callable, Callable]:
        """What `descend` asks for.

        Args:
            models: The models.

        Returns:
            Costs and Jacobians of these models.
        """

        def costs(point: Float[np.ndarray, " n"]) -> Float[np.ndarray, " models"]:
            commands = _command(jnp.asarray(point), self.within, self.move_time, on=self.on)
            return np.asarray(run(models, commands, self.on).cost)

        def linearised(point: Float[np.ndarray, " n"], rows: np.ndarray):
            given = jnp.asarray(point), self.within, self.move_time
            return linearise(
                models.rows(rows),
                _command(*given, on=self.on),
                _directions(*given, on=self.on),
                self.on,
            )

        return costs, linearised


@functools.partial(jax.jit, static_argnames="on")
def _command(
    point: Float[Array, " n"], within: Admissible, move_time: Float[Array, ""], *, on: Grid
) -> Command:
    return command(law(Unknowns.of(point), move_time, within), on=on)


_told = jax.jit(command, static_argnames="on")


@functools.partial(jax.jit, static_argnames="on")
def _directions(
    point: Float[Array, " n"], within: Admissible, move_time: Float[Array, ""], *, on: Grid
) -> Command:
    """How the command changes with each of the unknowns, stacked."""
    slopes = jax.jacfwd(lambda at: _command(at, within, move_time, on=on))(point)
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), slopes)


def _starts(models: Models, within: Admissible, move_time: float) -> list[_Start]:
    """The catalogue's positive shapers at the models' frequencies."""
    share = within.share(*_WISH)
    controller = within.controller(jnp.asarray(share))
    starts = []
    for frequency, entry in itertools.product(held_frequencies(models), CATALOGUE):
        shaper = entry.design(frequency, 0.0)
        fits = shaper.times.size <= IMPULSES and float(shaper.duration) < move_time / 2
        if fits and bool(jnp.all(shaper.amplitudes > 0)):
            point = start(shaper, move_time=move_time, gains=share).flat()
            exactly = shaped(controller, shaper, move_time=move_time)
            starts.append(_Start(exactly, np.asarray(point)))
    return starts


def _ranked(few: Models, on: Grid, starts: Sequence[_Start]) -> list[_Start]:
    """The starts, the best first."""
    values = [
        value_at_risk(np.asarray(run(few, _told(one.law, on=on), on).cost), _FEW_SHARE)
        for one in starts
    ]
    return [starts[number] for number in np.argsort(values, kind="stable")]
