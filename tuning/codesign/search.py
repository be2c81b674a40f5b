"""Gains, impulses and the leg's shape together, for the worst of many models.

The models are many and their worst share decides, so the work is done where it is cheap: the
catalogue's shapers are ranked, and descended from, on a few of the models; all of them see
only the last descent, and what is found is run at the controllers' own rate.

The merit has many minima, and neither the rank nor a descent on a few of the models says which
of them is least. So several starts are descended from to the end, independently of each other
and of other move times: whoever has a core to spare can take one. What the best two end in
are starts for the move times beside. To begin each move time from the design of the one before
would be cheaper, finds less (see docs/decisions.md), and each would have to wait for the last.
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

from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.codesign.designed import SHARE, Designed, evaluate, ranked
from tuning.codesign.models import Models
from tuning.codesign.outcomes import Command, Grid, grid, linearise, run
from tuning.codesign.shaped_legs import held_frequencies
from tuning.codesign.tail import descend, value_at_risk
from tuning.codesign.unknowns import IMPULSES, Law, Unknowns, command, law, start
from tuning.loop.admissible import Admissible
from tuning.shapers.catalogue import CATALOGUE

COARSE = 2e-3
"""Sample period of the search [s]."""
STARTS = 3
"""Shapers of the catalogue that are descended from, for each move time."""

_FEW = 120
"""Models that the search begins on."""
_FEW_SHARE = 0.2
"""Share of them that counts [1]: as many that one chunk's Jacobians are used."""
_STEPS, _LAST_STEPS = 12, 8
"""Steps of a descent on a few of the models, and on all."""
_WISH = (60.0, np.deg2rad(60.0))
"""Crossover and phase margin of a bare drive that a search starts with, or what comes nearest
to them within the bounds [rad/s, rad]; Eq. (25) has 40 rad/s."""


class Start(NamedTuple):
    """Where a descent starts."""

    point: Float[np.ndarray, " n"]
    """Flat unknowns."""
    move_time: float
    """Time from the reference's begin to its end, the shaper included [s]."""


class Search(NamedTuple):
    """What designs are sought for."""

    models: Models
    """The models."""
    within: Admissible
    """Which gains are admissible."""
    longest: float
    """Longest move that is asked for [s]: one compilation then serves all."""

    @property
    def few(self) -> Models:
        """Some of the models, spread over all of them."""
        return self.models.rows(scattered(len(self.models), _FEW))

    def starts(self, move_time: float) -> list[Start]:
        """The best of the catalogue's positive shapers at the models' frequencies.

        Args:
            move_time: Time from the reference's begin to its end, the shaper included [s].

        Returns:
            `STARTS` of them at the most, the best first.
        """
        few, starts = self.few, _starts(self.models, self.within, move_time)
        costs, _ = self.objective(move_time).of(few)
        values = [value_at_risk(costs(one.point), _FEW_SHARE) for one in starts]
        return [starts[number] for number in np.argsort(values, kind="stable")[:STARTS]]

    def objective(self, move_time: float) -> "Objective":
        """What is least where a move takes some time.

        Args:
            move_time: Time from the reference's begin to its end, the shaper included [s].

        Returns:
            The objective, on the search's samples.
        """
        return Objective(self.within, jnp.asarray(move_time), grid(self.longest, COARSE))

    def design(self, begin: Start, *, progress: Progress = SILENT) -> Designed:
        """The design that a descent from one start ends in.

        Args:
            begin: The start.
            progress: Told what is being done and which share of it is done.

        Returns:
            That design, or the start itself where it is better.
        """
        objective = self.objective(begin.move_time)
        first = descend(
            *objective.of(self.few),
            begin.point,
            share=_FEW_SHARE,
            iterations=_STEPS,
            progress=progress.part(0.0, 0.3, "co-design: a few models"),
        )
        last = descend(
            *objective.of(self.models),
            first.point,
            share=SHARE,
            iterations=_LAST_STEPS,
            progress=progress.part(0.3, 0.9, "co-design: all models"),
        )
        progress("co-design: at the controllers' rate", 0.9)
        designs = [
            dataclasses.replace(
                evaluate(self.models, objective.law(jnp.asarray(point)), longest=self.longest),
                point=point,
            )
            for point in (last.point, begin.point)
        ]
        return ranked(designs, self.models)[0]


Designer = Callable[[Search, Sequence[Start], Progress], Sequence[Designed]]
"""From what is sought, and starts, to the design that each of them ends in."""


def in_turn(search: Search, starts: Sequence[Start], progress: Progress) -> list[Designed]:
    """The designs that starts end in, one after the other.

    Args:
        search: What is sought.
        starts: The starts.
        progress: Told what is being done and which share of it is done.

    Returns:
        The designs.
    """
    ends = np.linspace(0.0, 1.0, len(starts) + 1)
    return [
        search.design(begin, progress=progress.part(first, last, f"{begin.move_time:.3g} s"))
        for begin, first, last in zip(starts, ends, ends[1:], strict=False)
    ]


def co_design(
    models: Models,
    within: Admissible,
    *,
    move_time: float,
    longest: float | None = None,
    progress: Progress = SILENT,
) -> Designed:
    """The design that is best for the worst of many models.

    Args:
        models: The models.
        within: Which gains are admissible.
        move_time: Time from the reference's begin to its end, the shaper included [s].
        longest: Longest move that will be asked for [s]: one compilation then serves all;
            None for this one.
        progress: Told what is being done and which share of it is done.

    Returns:
        The best design seen; where one keeps the drives within their limit, one that does.

    Raises:
        ValueError: If the move takes no longer than the catalogue's shapers.
    """
    search = Search(models, within, longest or move_time)
    progress("co-design: shapers of the catalogue", 0.0)
    starts = search.starts(move_time)
    if not starts:
        raise ValueError(
            f"`move_time` is too short for a shaper, got {move_time:.3g} s [s], expected more "
            "than two periods of the slowest mode. Give the move more time."
        )
    return ranked(in_turn(search, starts, progress.part(0.1, 1.0)), models)[0]


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


@functools.partial(jax.jit, static_argnames="on")
def _directions(
    point: Float[Array, " n"], within: Admissible, move_time: Float[Array, ""], *, on: Grid
) -> Command:
    """How the command changes with each of the unknowns, stacked."""
    slopes = jax.jacfwd(lambda at: _command(at, within, move_time, on=on))(point)
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), slopes)


def _starts(models: Models, within: Admissible, move_time: float) -> list[Start]:
    """The catalogue's positive shapers at the models' frequencies."""
    gains = within.share(*_WISH)
    starts = []
    for frequency, entry in itertools.product(held_frequencies(models), CATALOGUE):
        shaper = entry.design(frequency, 0.0)
        fits = shaper.times.size <= IMPULSES and float(shaper.duration) < move_time / 2
        if fits and bool(jnp.all(shaper.amplitudes > 0)):
            unknowns = start(shaper, move_time=move_time, gains=gains)
            starts.append(Start(np.asarray(unknowns.flat()), move_time))
    return starts
