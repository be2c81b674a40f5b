"""A logged leg again: the undriven coordinates along the way that the drives led them.

Encoders tell where lower carriage and height were, so what is left to the model is what a
plan's search leaves to it, with the same step and its derivatives
(`scdpr_jax.engines.led_stepping`). And what the drives were told tells what it took.
"""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.engines.led_stepping import Lead, Undriven, step, whole_position
from scdpr_jax.native import Slopes
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import inverse_dynamics, stretch
from tuning.plan.profile import Moment
from tuning.refinement.corrections import CORRECTIONS, with_corrections
from tuning.refinement.logged_leg import STEP, LoggedLeg, Way

NUISANCES = 2
"""What is corrected of each leg's start: where it rested [m], and the line's slope [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Replayed:
    """What a robot does along a logged leg, with derivatives."""

    position: Float[np.ndarray, "steps 3"]
    r"""$[x_e, \delta_e, q_4]$ as the steps begin [m, rad, m]."""
    voltage: Float[np.ndarray, "steps 2"]
    """What the way asks for by dynamics inversion [V]."""
    slopes: tuple[Float[np.ndarray, "steps 3 n"], Float[np.ndarray, "steps 2 n"]]
    """Their derivatives by the corrections and the start's."""


@dataclasses.dataclass(frozen=True, eq=False)
class Replay:
    """A leg for replaying by a robot and those that differ from it."""

    robot: Robot
    """The fitted robot."""
    leg: LoggedLeg
    """The leg."""

    @functools.cached_property
    def way(self) -> Way:
        """Where the drives led it."""
        return Way.of(self.leg, float(self.robot.drive.effective_radius))

    @functools.cached_property
    def _runs(self) -> native.Runs:
        stacked = _behind_an_axis(self.robot)
        return native.Runs(_advance, (stacked, np.array([STEP])))

    def __call__(
        self, shares: Float[np.ndarray, " n"], start: Float[np.ndarray, "2"]
    ) -> Replayed:
        """What a corrected robot does.

        Args:
            shares: See `corrections.with_corrections`.
            start: By how much place [m] and slope [1] of its start differ from the log's.

        Returns:
            Its motion and what it takes, with derivatives by both.
        """
        (x, y), away = self.leg.place, float(self.robot.frame.height)
        x, slope = x + start[0], self.leg.slope + start[1]
        begin = np.array([x, np.arctan(slope), x - slope * (away - y)])
        way = self.way
        lead = Lead(way.lead.lower + (x + slope * y), way.lead.height + y)
        count = len(CORRECTIONS) + NUISANCES
        aside = np.zeros((1, count, 3))
        aside[0, -2] = 1.0, 0.0, 1.0
        aside[0, -1] = 0.0, 1 / (1 + slope**2), y - away
        along = np.zeros((1, count, 1, 1))
        along[0, -2:, 0, 0] = 1.0, y
        steps = lead.lower.shape[1]
        moved = Lead(np.broadcast_to(along, (1, count, steps, 3)), None)
        (_, (position, voltage)), slopes = self._runs.linearised(
            (shares[None], Undriven(begin[None], np.zeros((1, 3)))),
            (lead, way.velocity, way.acceleration),
            along=Slopes(
                (
                    np.eye(count, len(CORRECTIONS))[None],
                    Undriven(aside, np.zeros((1, count, 3))),
                ),
                (moved, None, None),
            ),
        )
        return Replayed(position[0], voltage[0], tuple(own[0] for own in slopes.rows))


_Row = tuple[Lead, Float[Array, "2"], Float[Array, "2"]]


def _advance(
    parameters: tuple[Robot, Array], carry: tuple[Float[Array, " n"], Undriven], row: _Row
) -> tuple[tuple[Float[Array, " n"], Undriven], tuple[Float[Array, "3"], Float[Array, "2"]]]:
    """A step; the corrections are carried, so that tangents reach them."""
    (robot, duration), (shares, state), (lead, velocity, acceleration) = parameters, carry, row
    robot = with_corrections(robot, shares)
    position = whole_position(state.position, lead.lower[0], lead.height[0])
    driven = jnp.stack([lead.lower[0], lead.height[0]])
    # Encoders are ahead of the carriage by what the cables between them give.
    given = stretch(robot, position, Moment(driven, velocity, acceleration))
    volts = inverse_dynamics(robot, position, velocity, acceleration)
    following = step(robot, state, Lead(lead.lower - given, lead.height), duration)
    return (shares, following), (state.position, volts)


def _behind_an_axis(robot: Robot) -> Robot:
    return jax.tree.map(lambda leaf: np.asarray(leaf, float)[None], robot)
