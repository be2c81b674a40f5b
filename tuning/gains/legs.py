"""Random legs of robots as they might be, run side by side under laws of their own."""

from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int, PyTree

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw, unshaped
from scdpr_jax.legs.ensemble import Ensemble, stacked
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.legs.random_legs import LEG_TIMES, RandomLegs
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.gains.design import LONGEST

LANES = 96
"""Legs simulated side by side."""
HOLD = 0.8
"""Time that is looked at after a leg [s]: two and a half periods of 3 Hz."""
PERIOD = 2.5e-3
"""Sample period of the search [s]."""
IMPULSES = 4
"""Room for a shaper's impulses; idle ones have no amplitude."""
_SAMPLES = round((LEG_TIMES[1] + LONGEST + HOLD) / PERIOD) + 1


class Law(eqx.Module):
    """What is told to a robot on a leg; stacked, one a leg."""

    controller: PD
    """The controller of both drives, at `PERIOD`."""
    shaper: Shaper
    """The impulses, `IMPULSES` of them."""


class Legs(eqx.Module):
    """Robots as they might be and their legs, one a row; as NumPy arrays until they are run."""

    ensemble: Ensemble
    """The robots, at rest where their legs begin."""
    end: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("m"))
    """Where they end [m]."""
    time: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("s"))
    """Times of the legs [s]."""

    def __len__(self) -> int:
        return len(self.ensemble)

    def rows(self, rows: Int[np.ndarray, " n"]) -> "Legs":
        """Some of the legs.

        Args:
            rows: Which.

        Returns:
            These.
        """
        return jax.tree.map(lambda leaf: leaf[rows], self)


def legs_of(robots: Sequence[Robot], drawn: RandomLegs) -> Legs:
    """Legs with a robot each.

    Args:
        robots: The robots; they take turns.
        drawn: The legs.

    Returns:
        As many as were drawn.
    """
    each = [robots[number % len(robots)] for number in range(len(drawn))]
    ensemble = stacked(each, drawn.start, out_of_line=drawn.out_of_line)
    return Legs(ensemble, np.asarray(drawn.end), np.asarray(drawn.time))


def joined(parts: Sequence[Legs]) -> Legs:
    """Legs one after the other.

    Args:
        parts: The legs.

    Returns:
        All of them.
    """
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)


def plain_law() -> Law:
    """The PD of Eq. (25) without a shaper."""
    return Law(at_period(published_pd()), unshaped(IMPULSES))


def at_period(controller: PD) -> PD:
    """A controller's gains at the search's period.

    Args:
        controller: The controller.

    Returns:
        The controller.
    """
    return PD(controller.proportional_gain, controller.derivative_gain, PERIOD)


def runs(legs: Legs, laws: Law) -> LegMeasures:
    """Measures of many legs.

    They are run in chunks of `LANES`, so that one compiled function serves any number.

    Args:
        legs: The legs.
        laws: What each is told; or one law for all.

    Returns:
        The measures of each leg.
    """
    count = len(legs)
    if np.ndim(laws.shaper.times) == 1:
        laws = jax.tree.map(lambda leaf: np.stack([np.asarray(leaf)] * count), laws)
    chunks = [
        jax.tree.map(lambda leaf, rows=rows: np.asarray(leaf)[rows], (legs, laws))
        for rows in _chunks(count)
    ]
    parts = zip(*(_chunk(*chunk) for chunk in chunks), strict=True)
    return LegMeasures(*(np.concatenate(part)[:count] for part in parts))


def compile_runs(robot: Robot, drawn: RandomLegs) -> None:
    """Compiles what `runs` needs.

    Args:
        robot: Any robot with exact friction.
        drawn: Any legs.
    """
    legs, rows = legs_of([robot], drawn), _chunks(len(drawn))[0]
    laws = jax.tree.map(lambda leaf: np.stack([np.asarray(leaf)] * LANES), plain_law())
    _chunk.compile(legs.rows(rows), laws)


def _chunks(count: int) -> Int[np.ndarray, "chunks lanes"]:
    """Numbers of the legs in each chunk; the last one is filled up with the first leg."""
    rows = np.arange(count + -count % LANES)
    return np.where(rows < count, rows, 0).reshape(-1, LANES)


@kept_jit
def _chunk(legs: Legs, laws: Law) -> list[Float[Array, " lanes"]]:
    """The fields of `LegMeasures`."""
    judged = round(HOLD / PERIOD)

    def lane(own: Legs, law: Law) -> list[PyTree]:
        reference = rest_to_rest(own.ensemble.position, own.end, duration=own.time)
        told = CommandLaw(reference, law.controller, law.shaper)
        commands = told.commands(_SAMPLES, judged=judged)
        return jax.tree.leaves(
            run_leg(own.ensemble.robot, own.ensemble.start, commands).measures
        )

    return jax.vmap(lane)(legs, laws)
