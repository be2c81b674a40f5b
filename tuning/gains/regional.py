"""The shaper of every region, chosen over random legs that end in it."""

import dataclasses
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper, padded, residual_vibration
from scdpr_jax.legs.command_law import unshaped
from scdpr_jax.legs.random_legs import random_legs
from scdpr_jax.legs.share import share
from scdpr_jax.native import kept_jit
from tuning.gains.legs import IMPULSES, Law, Legs, at_period, joined, legs_of
from tuning.gains.loss import loss
from tuning.gains.outcome import outcome
from tuning.gains.possible_robots import PossibleRobot
from tuning.regions.cells import Cell
from tuning.regions.residual_map import worst_in_band
from tuning.result.prediction import LegsOutcome
from tuning.result.regional_shaper import RegionalShaper, ResidualVibration
from tuning.shapers.catalogue import CATALOGUE

OWN, NONE = "own", "none"
"""Names of shapers that aren't the catalogue's."""
LEGS = 12
"""Random legs that each region's shaper is chosen over."""
_CELLS = 8
"""Cells whose shapers are designed in one call."""
_FAMILIES = (NONE, *(e.name for e in CATALOGUE if e.name != "3hump_ei"))


@dataclasses.dataclass(frozen=True, eq=False)
class Candidates:
    """Shapers to choose from, for every cell."""

    names: tuple[str, ...]
    """`OWN`, `NONE`, or names of the catalogue."""
    shapers: tuple[tuple[Shaper, ...], ...]
    """Those of each cell, of `IMPULSES` impulses, in the order of the names."""

    def only(self, names: Sequence[str]) -> "Candidates":
        """Some of them.

        Args:
            names: Which.

        Returns:
            These.
        """
        numbers = [self.names.index(name) for name in names]
        chosen = tuple(tuple(row[k] for k in numbers) for row in self.shapers)
        return Candidates(tuple(names), chosen)


def candidates(cells: Sequence[Cell], own: Shaper) -> Candidates:
    """An optimised shaper, none, and the catalogue's at each cell's frequency.

    Args:
        cells: The cells.
        own: The optimised shaper.

    Returns:
        The candidates.
    """
    columns = np.array([(cell.frequency, cell.damping_ratio) for cell in cells])
    parts = [_catalogue(*columns[few].T) for few in _some_at_a_time(len(cells))]
    times, amplitudes = (
        np.concatenate(part)[: len(cells)] for part in zip(*parts, strict=True)
    )
    shapers = []
    for number in range(len(cells)):
        others = [Shaper(*pair) for pair in zip(times[number], amplitudes[number], strict=True)]
        shapers.append((padded(own, IMPULSES), *others))
    return Candidates((OWN, *_FAMILIES), tuple(shapers))


def cell_at(cells: Sequence[Cell], place: Float[np.ndarray, "2"]) -> int:
    """The cell that a place lies in.

    Args:
        cells: The cells.
        place: The place [m].

    Returns:
        The cell's number.
    """
    x, y = place
    return next(
        number
        for number, cell in enumerate(cells)
        if cell.region.x[0] <= x <= cell.region.x[1]
        and cell.region.y[0] <= y <= cell.region.y[1]
    )


def legs_into(
    cells: Sequence[Cell], robots: Sequence[PossibleRobot], *, count: int, seed: int
) -> list[Legs]:
    """Random legs that end in each cell, of robots that have the cell's frequency.

    Args:
        cells: The cells.
        robots: Robots as they might be.
        count: Legs for each cell.
        seed: Of the random numbers.

    Returns:
        The legs of each cell.
    """
    parts = []
    for number, cell in enumerate(cells):
        region = cell.region
        drawn = random_legs(
            robots[0].drawn.frame, count, seed=seed + number, x=region.x, y=region.y
        )
        parts.append(legs_of([robot.inside(cell) for robot in robots], drawn))
    return parts


def legs_anywhere(
    cells: Sequence[Cell], robots: Sequence[PossibleRobot], *, count: int, seed: int
) -> tuple[Legs, list[int]]:
    """Random legs over the workspace.

    Args:
        cells: The cells.
        robots: Robots as they might be; leg k is of robot k modulo their number.
        count: How many.
        seed: Of the random numbers.

    Returns:
        The legs, of robots that have the frequency of the cell that they end in, and the
        number of that cell for each.
    """
    drawn = random_legs(robots[0].drawn.frame, count, seed=seed)
    inside = [cell_at(cells, end) for end in drawn.end]
    every = {
        (cell, k): robots[k].inside(cells[cell])
        for cell in set(inside)
        for k in range(len(robots))
    }
    each = [every[cell, number % len(robots)] for number, cell in enumerate(inside)]
    return legs_of(each, drawn), inside


def choose(
    cells: Sequence[Cell],
    legs: Sequence[Legs],
    before: Sequence[LegsOutcome],
    controller: PD,
    tried: Candidates,
) -> list[RegionalShaper]:
    """The candidate of the least loss in each cell, of those that aren't worse than plain.

    Args:
        cells: The cells.
        legs: Legs that end in each.
        before: What these legs come to under Eq. (25) alone.
        controller: The gains.
        tried: The candidates.

    Returns:
        A shaper for each cell.
    """
    rows = [
        (part, shaper) for part, own in zip(legs, tried.shapers, strict=True) for shaper in own
    ]
    parts, shapers = zip(*rows, strict=True)
    after = outcome(joined(parts), told(controller, shapers, legs=[*map(len, parts)]))
    count = len(legs[0])
    shape = len(cells), len(tried.names), count
    each = after.map(lambda own: own.reshape(shape))
    chosen, names, shares = [], [], []
    for number in range(len(cells)):
        here = each.map(lambda own, number=number: own[number])
        losses = loss(here, before[number])
        plain = np.broadcast_to(before[number].vibration, shape[1:])
        left = share(here.vibration, plain)
        # What is worse than plain comes after all that isn't, and what isn't finite last.
        order = np.lexsort((np.where(np.isfinite(losses), losses, np.inf), ~(left <= 1)))
        best = int(order[0])
        chosen.append(tried.shapers[number][best])
        names.append(tried.names[best])
        shares.append(float(left[best]))
    return _regional(cells, chosen, names, shares)


def told(controller: PD, shapers: Sequence[Shaper], *, legs: Sequence[int]) -> Law:
    """A law for each leg.

    Args:
        controller: The gains of all.
        shapers: Shapers of `IMPULSES` impulses at the most.
        legs: How many legs each is for.

    Returns:
        The laws, one a leg.
    """
    coarse = jax.tree.map(np.asarray, at_period(controller))
    # Few shapers serve thousands of legs.
    distinct = {id(shaper): padded(shaper, IMPULSES) for shaper in shapers}
    every = [distinct[id(shaper)] for shaper in shapers]
    times, amplitudes = (
        np.repeat(np.stack([np.asarray(own) for own in numbers]), legs, axis=0)
        for numbers in zip(*((own.times, own.amplitudes) for own in every), strict=True)
    )
    return Law(
        jax.tree.map(lambda leaf: np.full(len(times), leaf), coarse), Shaper(times, amplitudes)
    )


@kept_jit
def _catalogue(
    frequency: Float[Array, " cells"], damping_ratio: Float[Array, " cells"]
) -> tuple[Float[Array, "cells shapers impulses"], Float[Array, "cells shapers impulses"]]:
    """Times and amplitudes of none and of the catalogue's shapers, padded.

    Idle impulses have no amplitude; where a shaper can't be made for a cell there is none.
    """

    def of_cell(*mode: Float[Array, ""]) -> tuple[Array, Array]:
        named = {entry.name: entry.design for entry in CATALOGUE}
        designs = [named[name](*mode) for name in _FAMILIES[1:]]
        fitting = [padded(own, IMPULSES) for own in (unshaped(), *designs)]
        times = jnp.stack([own.times for own in fitting])
        amplitudes = jnp.stack([own.amplitudes for own in fitting])
        made = jnp.isfinite(times + amplitudes).all(axis=1, keepdims=True)
        return jnp.where(made, times, times[0]), jnp.where(made, amplitudes, amplitudes[0])

    return jax.vmap(of_cell)(frequency, damping_ratio)


def _regional(
    cells: Sequence[Cell],
    shapers: Sequence[Shaper],
    names: Sequence[str],
    left: Sequence[float],
) -> list[RegionalShaper]:
    """The chosen shapers, without their idle impulses, and what they leave of each mode."""
    numbers = [(*cell.band, cell.frequency, cell.damping_ratio) for cell in cells]
    impulses = [(np.asarray(own.times), np.asarray(own.amplitudes)) for own in shapers]
    rows = _some_at_a_time(len(cells))
    parts = [_residuals(*(np.array(own)[few] for own in (numbers, impulses))) for few in rows]
    residuals = np.concatenate(parts)[: len(cells)]
    made = []
    for cell, (times, amplitudes), name, own, residual in zip(
        cells, impulses, names, left, residuals, strict=True
    ):
        used = amplitudes != 0
        made.append(
            RegionalShaper(
                region=cell.region,
                height=cell.height,
                shaper=Shaper(times[used], amplitudes[used]),
                frequency=cell.frequency,
                band=cell.band,
                damping_ratio=cell.damping_ratio,
                measured=cell.measured,
                residual_vibration=ResidualVibration(*residual.tolist()),
                kind=name,
                share=own,
            )
        )
    return made


@kept_jit
def _residuals(
    numbers: Float[Array, "cells 4"], impulses: Float[Array, "cells 2 impulses"]
) -> Float[Array, "cells 2"]:
    """What shapers leave of modes, and at most in bands, by these and damping ratios [1]."""

    def of_cell(
        numbers: Float[Array, "4"], impulses: Float[Array, "2 impulses"]
    ) -> Float[Array, "2"]:
        low, high, frequency, ratio = numbers
        shaper = Shaper(*impulses)
        nominal = residual_vibration(shaper, frequency=frequency, damping_ratio=ratio)
        worst = worst_in_band(shaper, band=jnp.stack([low, high]), damping_ratio=ratio)
        return jnp.stack([nominal, worst])

    return jax.vmap(of_cell)(numbers, impulses)


def _some_at_a_time(count: int) -> Int[np.ndarray, "parts cells"]:
    """Cells in parts of one size, the first ones again at the end, for one compiled program."""
    return np.arange(count + -count % _CELLS).reshape(-1, _CELLS) % count
