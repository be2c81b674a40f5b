"""What legs come to under laws of their own, judged as they run: no trace is kept.

A search asks for thousands of legs, each of a robot of its own, and wants two numbers of each.
Reference, shaper, controller, robot and judge are one step of machine code here, and legs that
end at about the same time run side by side for as long as these need. The two numbers are those
of `scdpr_jax.legs.measures`, which takes them from a whole leg's trace.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.command.controller import PDState
from scdpr_jax.command.shaper import ShapedTrajectory
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.numerics.side_by_side import side_by_side
from scdpr_jax.robot.kinematics import inverse_kinematics
from scdpr_jax.robot.state import HEIGHT, LOWER, UPPER, State, rest
from tuning.gains.legs import PERIOD, Law, Legs
from tuning.plan.expectation import Loop, Told, sample
from tuning.result.prediction import LegsOutcome

HOLD = 0.8
"""Time that is looked at after a leg [s]: two and a half periods of 3 Hz."""
_JUDGED = round(HOLD / PERIOD)
"""Samples of it."""
_LANES = 16
"""Legs that run side by side on a core, for as long as the longest of them."""


class _Seen(NamedTuple):
    """What the judged samples of a leg have shown so far."""

    count: Float[Array | np.ndarray, "..."]
    """Their number [1]."""
    farthest: Float[Array | np.ndarray, "... 2"]
    """Least and largest $x_e$ [m]."""
    last: Float[Array | np.ndarray, "... 5"]
    """Coordinates at the last of them [m, rad]."""


_Carry = tuple[State, PDState, _Seen]
_Leg = tuple[Legs, Law]


def outcome(legs: Legs, laws: Law) -> LegsOutcome:
    """What many legs come to.

    Args:
        legs: The legs.
        laws: What each is told; or one law for all.

    Returns:
        Vibration and resting error of each leg.
    """
    if np.ndim(laws.shaper.times) == 1:
        laws = jax.tree.map(lambda leaf: np.stack([np.asarray(leaf)] * len(legs)), laws)
    ends = np.asarray(legs.time) + np.asarray(laws.shaper.times)[:, -1]
    order = np.argsort(ends, kind="stable")
    lanes = jax.tree.map(lambda leaf: np.asarray(leaf)[order], (legs, laws, ends))
    made = side_by_side(_chunk, lanes, size=_LANES, program=_sample)
    vibration, resting = (own[np.argsort(order)] for own in made)
    return LegsOutcome(vibration, resting)


def _chunk(
    lanes: tuple[Legs, Law, Float[np.ndarray, " legs"]],
) -> tuple[Float[np.ndarray, " legs"], Float[np.ndarray, " legs"]]:
    """Vibrations and resting errors of legs that run for as long as the longest of them."""
    *leg, ends = lanes
    samples = int(np.ceil(ends.max() / PERIOD)) + _JUDGED + 1
    once, each = np.zeros((1, 1)), np.arange(samples, dtype=float)[None]
    _, begin = native.Runs(_begin, tuple(leg))((), once)
    start = jax.tree.map(lambda leaf: leaf[:, 0], begin)
    (_, _, seen), _ = native.Runs(_sample, (tuple(leg), start[0].driven))(start, each)
    _, resting = native.Runs(_resting, (tuple(leg), seen.last))((), once)
    return np.ptp(seen.farthest, axis=1), resting[:, 0]


def _begin(leg: _Leg, _: tuple, __: Float[Array, ""]) -> tuple[tuple, _Carry]:
    """A robot at rest, and a controller switched on."""
    (legs, _), zero, one = leg, jnp.zeros(2), jnp.ones(())
    start = legs.ensemble.start
    nothing = _Seen(jnp.zeros(()), jnp.inf * jnp.stack([one, -one]), start.position)
    return (), (start, PDState(zero, zero), nothing)


def _sample(
    given: tuple[_Leg, Float[Array, "2"]], carry: _Carry, number: Float[Array, ""]
) -> tuple[_Carry, tuple]:
    """A sample of a leg: judged, commanded, driven."""
    ((legs, law), begin), (state, memory, seen) = given, carry
    reference = rest_to_rest(legs.ensemble.position, legs.end, duration=legs.time)
    told = CommandLaw(reference, law.controller, law.shaper)
    time = law.controller.period * number
    is_judged = (time >= told.duration) & (seen.count < _JUDGED)
    place = ShapedTrajectory(reference, law.shaper).position(time) - legs.ensemble.position
    angle = inverse_kinematics(place, legs.ensemble.robot.drive.effective_radius)
    loop = Loop(legs.ensemble.robot, law.controller, begin)
    (following, memory), x = sample(loop, (state, memory), Told(angle, jnp.zeros(2)))
    low, high = seen.farthest
    here = _Seen(
        seen.count + 1,
        jnp.stack([jnp.minimum(low, x), jnp.maximum(high, x)]),
        state.position,
    )
    seen = jax.tree.map(lambda new, old: jnp.where(is_judged, new, old), here, seen)
    return (following, memory, seen), ()


def _resting(
    given: tuple[_Leg, Float[Array, "5"]], _: tuple, __: Float[Array, ""]
) -> tuple[tuple, Float[Array, ""]]:
    """How far from its target a robot rests, see `scdpr_jax.legs.measures`."""
    (legs, _), at = given
    place = rest(legs.ensemble.robot, at[LOWER], at[UPPER], at[HEIGHT])
    return (), jnp.linalg.norm(place.pose - legs.end)
