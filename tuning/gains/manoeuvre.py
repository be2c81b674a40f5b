"""The horizontal manoeuvre of Table 3, out and back, simulated before and after tuning."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper, padded
from scdpr_jax.command.trajectory import Manoeuvre, rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw, unshaped
from scdpr_jax.legs.ensemble import Ensemble, single
from scdpr_jax.legs.leg import Leg, leg_of, run_leg
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.parameters import Robot
from tuning.gains.design import LONGEST
from tuning.gains.legs import IMPULSES
from tuning.result.prediction import Metrics, Prediction

LEG_TIMES = (2.0, 4.0)
"""Times of a leg that are simulated [s]: what the rigs run the horizontal manoeuvre of Table 3
with (only that gives the paper's 50 mm), and what the table's letter says."""
HOLD = 1.0
"""Time that is looked at after the manoeuvre [s]: three periods of 3 Hz."""
SPAN = (0.3 / 2.224, 1.9 / 2.224)
"""Ends of the manoeuvre, as shares of the frame's width [1]."""
HEIGHT = 0.55 / 1.112
"""Its height, as a share of the frame's [1]."""


def predict(
    robot: Robot,
    controller: PD,
    shaper: Shaper,
    *,
    leg_times: tuple[float, ...] = LEG_TIMES,
) -> tuple[Prediction, ...]:
    """The manoeuvre at the controllers' own rate, before and after.

    Args:
        robot: The fitted robot.
        controller: The tuned gains.
        shaper: The shaper where the manoeuvre ends.
        leg_times: Times of a leg [s].

    Returns:
        A prediction for each time.
    """
    laws = (published_pd(), unshaped()), (controller, shaper)
    predictions = []
    for leg_time in leg_times:
        (before, run_before), (after, run_after) = (
            _simulated(robot, *law, leg_time, longest=max(leg_times)) for law in laws
        )
        name = f"horizontal manoeuvre, {leg_time:g} s a leg"
        predictions.append(Prediction(name, before, after, run_before, run_after))
    return tuple(predictions)


def _simulated(
    robot: Robot, controller: PD, shaper: Shaper, leg_time: float, *, longest: float
) -> tuple[Metrics, Leg]:
    # As many samples for every leg time, so that it compiles once; the rest is cut off.
    most, samples = (_samples_for(t, float(controller.period)) for t in (longest, leg_time))
    start, turn = (
        jnp.asarray([share * float(robot.frame.width), HEIGHT * float(robot.frame.height)])
        for share in SPAN
    )
    told = controller, padded(shaper, IMPULSES), jnp.asarray(leg_time)
    run = leg_of(_run(single(robot, start), turn, *told, most))
    return Metrics.of(run.measures), run.until(samples)


def _samples_for(leg_time: float, period: float) -> int:
    """Samples of a manoeuvre with the longest shaper and `HOLD` after it."""
    return round((2 * leg_time + LONGEST + HOLD) / period) + 1


@kept_jit
def _run(
    robot: Ensemble,
    turn: Float[Array, "2"],
    controller: PD,
    shaper: Shaper,
    leg_time: Float[Array, ""],
    samples: int,
) -> list[Float[Array | np.ndarray, "..."]]:
    """The arrays of a leg."""
    out = rest_to_rest(robot.position, turn, duration=leg_time)
    back = rest_to_rest(turn, robot.position, duration=leg_time)
    law = CommandLaw(Manoeuvre((out, back), 0.0), controller, shaper)
    return jax.tree.leaves(run_leg(robot.robot, robot.start, law.commands(samples)))
