"""Random legs of robots as they might be, and what each is told."""

from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.command_law import unshaped
from scdpr_jax.legs.ensemble import Ensemble, stacked
from scdpr_jax.legs.random_legs import RandomLegs
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot

PERIOD = 2.5e-3
"""Sample period of the search [s]."""
IMPULSES = 4
"""Room for a shaper's impulses; idle ones have no amplitude."""


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
